"""The page of a data set: one file, whole, from nothing outside, the same each time."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page import render_page
from tests.benchmarks.data.sets.hand_made import write_set
from tests.benchmarks.show.test_report import WellFormed


@pytest.fixture(scope="module")
def page(hand_made: DataSet) -> str:
    return render_page(hand_made)


@pytest.mark.heavy
def test_it_is_whole_and_needs_nothing_from_outside(page: str) -> None:
    parser = WellFormed()
    parser.feed(page)
    assert parser.open == []
    assert parser.addresses
    for address in parser.addresses:
        assert address.startswith(("#", "data:")), address
    assert "<script" not in page
    assert "@import" not in page
    assert re.findall(r"url\((?!#)", page) == []


def test_it_tells_what_the_set_is(page: str) -> None:
    text = re.sub(r"<[^>]+>", " ", page)
    assert "`" not in text
    assert "2 episodes (seeds 0–1), 60 frames of 160 x 120 pixels at 15 a second" in text
    assert "Missing: seeds 2." in text
    assert re.search(r"target\s+83.3\s+0.0\s+0.0\s+16.7\s+0.0\s+2\s+0\s+5, 5", text)
    # The contact sheet and the histograms.
    assert page.count("<img ") == 2


@pytest.mark.heavy
def test_it_is_the_same_each_time(page: str, hand_made: DataSet) -> None:
    assert render_page(DataSet(hand_made.url)) == page


def test_a_set_without_pixels_has_a_page_without_a_contact_sheet(tmp_path: Path) -> None:
    page = render_page(write_set(tmp_path, (), frames=2))
    assert page.count("<img ") == 1


def test_the_command_writes_it_beside_the_data_or_where_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_set(tmp_path / "set", ("depth_m",), frames=2)
    assert main(["show", str(tmp_path / "set")]) == 0
    assert main(["show", str(tmp_path / "set"), "--out", str(tmp_path / "other" / "a.html")]) == 0
    written = [tmp_path / "set" / "page.html", tmp_path / "other" / "a.html"]
    assert capsys.readouterr().out.split() == [str(path) for path in written]
    assert written[0].read_bytes() == written[1].read_bytes()


def test_a_page_that_cannot_be_written_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_set(tmp_path / "set", ("depth_m",), frames=2)
    for out, told in (
        ("/proc/nix/a.html", "out: expected a folder that can be written, got '/proc/nix'"),
        (str(tmp_path), f"out: expected a file, got the folder {str(tmp_path)!r}"),
    ):
        assert main(["show", str(tmp_path / "set"), "--out", out]) == 2
        assert told in capsys.readouterr().err


def test_a_folder_without_a_set_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "directory: expected a data set with a file dataset.json, got none in" in error
