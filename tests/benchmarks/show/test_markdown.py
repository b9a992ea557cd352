"""Tables as Markdown."""

from __future__ import annotations

import re

import pytest

from benchmarks.show.tables import markdown_table


def test_a_bar_in_a_cell_is_escaped() -> None:
    assert markdown_table(["a|b"], [["|c|"]], words=1) == "| a\\|b |\n| --- |\n| \\|c\\| |"


def test_a_reader_of_markdown_finds_the_cells_that_were_given() -> None:
    markdown_it = pytest.importorskip("markdown_it", reason="the docs extra is not installed")
    heads, lines = ["counted", "here"], [["|ΔR| + |ΔB|", "1.00"], ["a lamp", "0.60"]]
    page = markdown_it.MarkdownIt("commonmark").enable("table").render(markdown_table(heads, lines, words=1))
    rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in page.split("</tr>")[:-1]]
    assert rows == [heads, *lines]
    assert page.count("text-align:right") == len(rows)
