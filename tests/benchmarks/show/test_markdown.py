"""Tables as Markdown."""

from __future__ import annotations

import re

from markdown_it import MarkdownIt

from benchmarks.show.tables import markdown_table


def test_a_reader_of_markdown_finds_the_cells_that_were_given() -> None:
    heads, lines = ["counted", "here"], [["|ΔR| + |ΔB|", "1.00"], ["a lamp", "0.60"]]
    page = MarkdownIt("commonmark").enable("table").render(markdown_table(heads, lines, words=1))
    rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in page.split("</tr>")[:-1]]
    assert rows == [heads, *lines]
    assert page.count("text-align:right") == len(rows)
