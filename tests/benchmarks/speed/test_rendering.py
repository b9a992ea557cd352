"""The speed measurement: which work is timed."""

from __future__ import annotations

import time
from typing import Any

import pytest

from benchmarks.speed.rendering import UNTIMED_FRAMES, measure
from scenarios.scenario import Frame
from tests.benchmarks import fake_episode

COMPILING_S, DRAWING_S = 0.2, 0.002
BLURRED_FRAME = 20


def work(seconds: float) -> None:
    """Keep the processor busy."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


class FakeWorld:
    """Counts the bare calls."""

    calls = 0

    def hand_over(self) -> None:
        pass

    def camera_image(self, *args: Any, **options: Any) -> None:
        FakeWorld.calls += 1
        work(10 * DRAWING_S)


class Town(fake_episode.FakeEpisode):
    """Needs its own kernel at a late frame, slow in the first town of a process only."""

    compiled = False
    built: list[Town]

    def __init__(self) -> None:
        super().__init__(frame_count=40)
        self.world = FakeWorld()
        Town.built.append(self)

    def step(self, command: Any = None) -> Frame:
        work(DRAWING_S)
        if len(self.commands) == BLURRED_FRAME and not Town.compiled:
            work(COMPILING_S)
            Town.compiled = True
        return super().step(command)


@pytest.fixture(autouse=True)
def _fresh_process() -> None:
    Town.compiled, Town.built, FakeWorld.calls = False, [], 0


def test_a_kernel_that_a_late_frame_needs_first_is_not_timed():
    sample = measure(Town, 24)  # type: ignore[arg-type]
    assert Town.compiled
    assert len(sample.frame_s) == 24
    assert max(sample.frame_s) < 0.5 * COMPILING_S
    assert sample.speedup == pytest.approx(10, rel=0.5)


def test_the_timed_frames_are_those_rehearsed_and_every_town_is_closed():
    measure(Town, 24)  # type: ignore[arg-type]
    assert [len(town.commands) for town in Town.built] == [24 + UNTIMED_FRAMES] * 2
    assert all(town.closed for town in Town.built)
    assert FakeWorld.calls == 1 + 24 // 8


def test_more_frames_than_an_episode_has_are_refused():
    with pytest.raises(ValueError, match=r"frames: expected at most 35, .* got 36"):
        measure(Town, 36)  # type: ignore[arg-type]
