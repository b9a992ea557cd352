"""The scenario whose target is a sheet goes through every command, and trackers are benchmarked on it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_blocks
from scenarios.paper_sheet.scenario import PAPER_SHEET
from trackers import registry
from trackers.types import Estimate, Observation

TRACKERS = ("stereo_people", "stereo_wb_shutter_gain", "opencv_mil")


@pytest.fixture(params=["paper-b1", "paper-b2"])
def preset(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """A preset, made short."""
    short = {"paper-b1": {"illuminances_lx": (609.0, 19.0) * 4}, "paper-b2": {"frame_count": 24}}[request.param]
    monkeypatch.setitem(PAPER_SHEET.presets, request.param, replace(PAPER_SHEET.presets[request.param], **short))
    return request.param


class Still:
    """Answers the box that it was given."""

    Parameters = registry.NoParameters

    def __init__(self, parameters: registry.NoParameters, rng: np.random.Generator) -> None:
        pass

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self._box_xyxy = box_xyxy

    def update(self, observation: Observation) -> Estimate:
        return Estimate(0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:]), self._box_xyxy.copy())


@pytest.fixture
def still(monkeypatch: pytest.MonkeyPatch) -> str:
    """A tracker that takes part in suite ``stereo``, for as long as the test lasts."""
    entry = registry.TrackerEntry(
        "still", "baseline", "stays", Still, {}, "still", True, True, ("stereo",), lambda: "", 1
    )
    monkeypatch.setitem(registry._ENTRIES, "still", entry)
    return "still"


@pytest.mark.heavy
def test_trackers_are_benchmarked_on_it(
    preset: str, still: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["bench", "stereo", "--preset", preset, "--seeds", "0:1", "--workers", "0", "--out", str(tmp_path)]
    assert main([*words, "--trackers", *TRACKERS, still]) == 0
    assert "error" not in capsys.readouterr().err
    blocks = read_blocks(tmp_path)
    assert {key.tracker for key in blocks} == {*TRACKERS, still}
    frames = PAPER_SHEET.presets[preset].frame_count
    for rows in blocks.values():
        told = {row["metric"]: row["value"] for row in rows}
        assert told["visible_fraction_by_frame"] == pytest.approx([1.0] * frames, abs=0.01)
        assert told["right_frames"] + told["wrong_frames"] + told["missed_frames"] == frames - 1
        assert told["disparity_density_target"] > 0.5
    # A sheet that never moves in the picture is not lost by a fixed estimate.
    still = next(rows for key, rows in blocks.items() if key.tracker == "still")
    assert next(row["value"] for row in still if row["metric"] == "right_frames") == frames - 1
    assert "Disparity matched from the pair" in (tmp_path / "report.html").read_text()


def test_nobody_steers_in_it(preset: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "stereo", "--preset", preset, "--controllers", "centre", "--trackers", "opencv_mil"]
    assert main([*words, "--seeds", "0:1", "--workers", "0", "--out", str(tmp_path)]) == 2
    assert "controllers: expected one of set-path; got 'centre'" in capsys.readouterr().err
