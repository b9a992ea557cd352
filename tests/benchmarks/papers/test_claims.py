"""Tables of findings can be read in a terminal of 80 columns."""

from __future__ import annotations

import re

import pytest

from benchmarks.papers.claims import Claim, Finding, print_findings

CLAIM = Claim(
    "kept_rate", "kept in the picture to the end", "it stays", "at least", 0.9, tracker="stereo_wb_shutter_gain"
)


@pytest.mark.parametrize("renderers", [("raster",), ("raster", "pybullet")])
def test_names_and_numbers_are_whole_in_80_columns(
    renderers: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    found = [Finding(CLAIM, renderer, 0.94, 0.8, 0.99, "fraction", 50) for renderer in renderers]
    print_findings("A2", found, range(50))
    told = capsys.readouterr().out
    assert told.count(" stereo_wb_shutter_gain ") == len(renderers)
    assert all(f" {renderer} " in told for renderer in renderers[1:])
    assert told.count(" 94.0 % ") == len(renderers)
    # The last column: a table that is too wide loses what is on its right.
    assert len(re.findall(r" yes\b", told)) == len(renderers)
    # One renderer stands in the title.
    assert ("renderer raster" in told) == (len(renderers) == 1)
