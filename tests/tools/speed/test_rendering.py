"""The speed of rendering: which work is timed, and what is printed of it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenarios.scenario import Frame
from tests.benchmarks import fake_episode
from tests.tools.command import tools
from tests.tools.speed.conftest import BARE_S, FakeWorld, work
from tools.speed import rendering
from tools.speed.figures import UNTIMED_FRAMES, Figure, entries_of
from tools.speed.rendering import frame_times, measure_rendering

COMPILING_S, DRAWING_S, TRUTH_S = 0.2, 0.002, 0.002
BLURRED_FRAME = 20


class FakeCamera:
    """Takes pictures."""

    def take(self) -> None:
        work(DRAWING_S)


class Town(fake_episode.FakeEpisode):
    """Needs its own kernel at a late frame, slow in the first town of a process only."""

    compiled = False
    built: list[Town]

    def __init__(self) -> None:
        super().__init__(frame_count=40)
        self.world = FakeWorld()
        self._camera: Any = FakeCamera()
        Town.built.append(self)

    def step(self, command: Any = None) -> Frame:
        self._camera.take()
        work(TRUTH_S)
        if len(self.commands) == BLURRED_FRAME and not Town.compiled:
            work(COMPILING_S)
            Town.compiled = True
        return super().step(command)


@pytest.fixture(autouse=True)
def _fresh_process() -> None:
    Town.compiled, Town.built = False, []


def test_frames_pictures_and_bare_calls_are_timed_apart_and_compiling_is_not() -> None:
    frame_s, _, picture_s, bare_s, shadowless_s = frame_times(Town, 24)
    assert Town.compiled
    assert frame_s / picture_s == pytest.approx((DRAWING_S + TRUTH_S) / DRAWING_S, rel=0.3)
    assert bare_s == pytest.approx(BARE_S, rel=0.3)
    assert bare_s / shadowless_s == pytest.approx(2.0, rel=0.3)
    # The timed frames are those rehearsed, and every town is closed.
    assert [len(town.commands) for town in Town.built] == [24 + UNTIMED_FRAMES] * 2
    assert all(town.closed for town in Town.built)
    assert FakeWorld.calls == 2 * (1 + 24 // 8)


def test_more_frames_than_an_episode_has_are_refused() -> None:
    with pytest.raises(ValueError, match=r"frames: expected at most 35, .* got 36"):
        frame_times(Town, 36)


def test_ratios_are_of_the_times_of_one_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "frame_times", lambda build, frames: (0.002, 0.002, 0.001, 0.008, 0.004))
    monkeypatch.setattr(rendering, "process_throughput", lambda *arguments: 1.0)
    figures = measure_rendering("road-town-v2", "standard", 8, 0)
    assert {metric: each.above / each.below for metric, each in figures.items()} == pytest.approx(
        {
            "speedup_over_tinyrenderer": 4.0,
            "speedup_over_tinyrenderer_without_shadows": 2.0,
            "picture_speedup_over_tinyrenderer": 8.0,
            "frames_per_s": 500.0,
            "process_scaling": 1.0,
            "frame_cpu_ms": 2.0,
            "tinyrenderer_cpu_ms": 8.0,
            "picture_cpu_ms": 1.0,
        }
    )


def test_episodes_have_the_ratio_of_their_sums() -> None:
    measured = [{"speedup": Figure(8.0, 2.0)}, {"speedup": Figure(1.0, 1.0)}]
    (entry,) = entries_of("road-town-v2", "standard", "raster", range(3, 5), measured)
    assert entry["mean"] == 3.0
    assert (entry["ci_low"], entry["ci_high"], entry["n"]) == (1.0, 4.0, 2)
    assert (entry["unit"], entry["better"], entry["tracker"]) == ("ratio", "higher", "raster")


def test_the_command_prints_a_table_and_keeps_the_summary(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    measured = []

    def measure(*given: Any) -> dict[str, Figure]:
        measured.append(given)
        return {"speedup_over_tinyrenderer": Figure(6.1, 2.0)}

    monkeypatch.setattr("tools.time_speed.measure_rendering", measure)
    monkeypatch.setattr("tools.time_speed.is_playable", lambda *_: False)
    assert tools(["speed", "harbour", "--seeds", "3:5", "--frames", "20", "--out", str(tmp_path)]) == 0
    assert measured == [("harbour-v1", "standard", 20, seed) for seed in (3, 4)]
    assert re.search(r"speedup_over_tinyrenderer .*3\.05 ", capsys.readouterr().out)
    (kept,) = json.loads((tmp_path / "summary.json").read_text())
    assert np.isclose(kept["mean"], 3.05)
