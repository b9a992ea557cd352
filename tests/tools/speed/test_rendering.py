"""The speed measurement: which work is timed."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from scenarios.scenario import Frame
from tests.benchmarks import fake_episode
from tools.speed import rendering
from tools.speed.rendering import UNTIMED_FRAMES, measure, measure_scenario

COMPILING_S, DRAWING_S, TRUTH_S = 0.2, 0.002, 0.002
BLURRED_FRAME = 20


def work(seconds: float) -> None:
    """Keep the processor busy."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


class FakeWorld:
    """Counts the bare calls; those without shadows are half the work."""

    calls = 0

    def hand_over(self) -> None:
        pass

    def camera_image(self, *args: Any, shadows: bool, **options: Any) -> None:
        FakeWorld.calls += 1
        work((20 if shadows else 10) * DRAWING_S)


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
        self._camera = FakeCamera()
        Town.built.append(self)

    def step(self, command: Any = None) -> Frame:
        self._camera.take()
        work(TRUTH_S)
        if len(self.commands) == BLURRED_FRAME and not Town.compiled:
            work(COMPILING_S)
            Town.compiled = True
        return super().step(command)


@pytest.fixture(autouse=True)
def _fresh_process(monkeypatch: pytest.MonkeyPatch) -> None:
    Town.compiled, Town.built, FakeWorld.calls = False, [], 0
    monkeypatch.setattr(rendering, "TinyRenderer", lambda world: world)


def test_a_kernel_that_a_late_frame_needs_first_is_not_timed():
    sample = measure(Town, 24)  # type: ignore[arg-type]
    assert Town.compiled
    assert len(sample.frame_s) == 24
    assert max(sample.frame_s) < 0.5 * COMPILING_S
    assert sample.speedup == pytest.approx(10, rel=0.5)


def test_pictures_and_bare_calls_without_shadows_are_timed_apart():
    sample = measure(Town, 24)  # type: ignore[arg-type]
    assert len(sample.picture_s) == 24
    assert (len(sample.bare_s), len(sample.shadowless_s)) == (3, 3)
    of = (sample.frame_s, sample.picture_s, sample.bare_s, sample.shadowless_s)
    frame_s, picture_s, bare_s, shadowless_s = (float(np.median(each)) for each in of)
    assert frame_s / picture_s == pytest.approx((DRAWING_S + TRUTH_S) / DRAWING_S, rel=0.3)
    assert bare_s / shadowless_s == pytest.approx(2.0, rel=0.3)
    assert shadowless_s / picture_s == pytest.approx(10.0, rel=0.3)


@pytest.mark.parametrize("ours", [True, False])
def test_pictures_have_figures_where_cameras_are_ours(monkeypatch, ours):
    """Bare calls of 8 and 4 ms, frames of 2 and pictures of 1 ms."""
    sample = rendering.SpeedSample((0.002,), (0.001,) if ours else (), (0.008,), (0.004,), 0.002)
    monkeypatch.setattr(rendering, "measure", lambda build, frames: sample)
    monkeypatch.setattr(rendering, "process_throughput", lambda *arguments: 1.0)
    entries = measure_scenario("road-town-v2", "standard", range(2), 8)
    ratios = {each["metric"]: each["mean"] for each in entries if "tinyrenderer" in each["metric"]}
    whole = {"": 4.0, "_without_shadows": 2.0}
    alone = {"": 8.0, "_without_shadows": 4.0} if ours else {}
    expected = {f"speedup_over_tinyrenderer{name}": value for name, value in whole.items()}
    expected |= {f"picture_speedup_over_tinyrenderer{name}": value for name, value in alone.items()}
    assert {name: value for name, value in ratios.items() if "speedup" in name} == pytest.approx(expected)


def test_the_timed_frames_are_those_rehearsed_and_every_town_is_closed():
    measure(Town, 24)  # type: ignore[arg-type]
    assert [len(town.commands) for town in Town.built] == [24 + UNTIMED_FRAMES] * 2
    assert all(town.closed for town in Town.built)
    assert FakeWorld.calls == 2 * (1 + 24 // 8)


def test_more_frames_than_an_episode_has_are_refused():
    with pytest.raises(ValueError, match=r"frames: expected at most 35, .* got 36"):
        measure(Town, 36)  # type: ignore[arg-type]
