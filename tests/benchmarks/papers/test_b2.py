"""Paper experiment B.2: the gain where D_l is positive is correct; a run leaves rows, plots and page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.contract.rows import read_blocks
from benchmarks.papers import b2
from benchmarks.papers.camera_experiment import SheetPicture
from benchmarks.papers.experiment import experiment_named, findings
from benchmarks.papers.repeat import repeat
from scenarios.paper_sheet.scenario import PAPER_SHEET
from trackers.types import CameraRegisters

EXPERIMENT = experiment_named("B2")
_SHUTTERS = [200] * 12 + list(range(200, 320, 4)) + list(range(320, 200, -4))


def _pictures(preset: str, seed: int, renderer: str = "raster") -> Iterator[SheetPicture]:
    """A sheet that is vivid while the exposure rises and pale while it falls."""
    before = _SHUTTERS[0]
    for shutter in _SHUTTERS:
        colour = (40, 200, 40) if shutter > before else (90, 100, 90)
        image = np.full((240, 320, 3), colour, np.uint8)
        before = shutter
        yield SheetPicture(image, CameraRegisters(512, 512, shutter, 0), np.array([100.0, 80.0, 220.0, 160.0]), 100.0)


@pytest.fixture
def drawn_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(b2, "photograph", _pictures)
    monkeypatch.setattr(b2, "_CEILING_LIGHT_FRAMES", 60)
    monkeypatch.setattr(b2, "_SHOWN_FRAMES", (0, 10, 20, 25, 30, 40, 50, 60))


@pytest.mark.usefixtures("drawn_drive")
def test_vivid_where_the_trend_is_positive_is_a_gain():
    values = EXPERIMENT.measure(0, "raster")
    trend, saturation = (np.array(values[name]) for name in ("trend", "saturation"))
    assert set(np.round(saturation, 2)) == {0.8, 0.1}
    expected = saturation[trend > 0].mean() - saturation[trend < 0].mean()
    assert values["saturation_gained"] == pytest.approx(expected)
    assert values["saturation_gained"] > 0.4
    assert values["value_gained"] > 0.2
    assert values["frames"] == len(_SHUTTERS)


@pytest.mark.usefixtures("drawn_drive")
def test_a_run_leaves_rows_plots_pictures_and_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    repeat(EXPERIMENT, tmp_path, range(2), "raster", 0)
    assert "paper.html" in capsys.readouterr().out
    assert [key.seed for key in read_blocks(tmp_path)] == [0, 1]
    page = (tmp_path / "paper.html").read_text()
    for claim in EXPERIMENT.claims:
        assert claim.words in page
    assert page.count("<svg") == 2
    assert (tmp_path / "pictures" / "paper-b2-raster.jpg").is_file()


@pytest.mark.heavy
def test_a_drive_comes_out_as_the_paper_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """In smaller pictures, which take a quarter of the time."""
    small = replace(PAPER_SHEET.presets[EXPERIMENT.preset], width_px=160, height_px=120)
    monkeypatch.setitem(PAPER_SHEET.presets, EXPERIMENT.preset, small)
    for finding in findings(EXPERIMENT, EXPERIMENT.block(0, "raster")):
        assert finding.agrees is not False, finding
