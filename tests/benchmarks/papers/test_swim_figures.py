"""Paper C's trajectories: which gaps are shown, and that the lost piece and its prediction are in the picture."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.judges.fish.gap_protocol import Gap, Tracks
from benchmarks.judges.fish.gap_scores import GapTask
from benchmarks.papers.swim_figures import Tank, turning_gap, usual_gap
from benchmarks.show.video import marks

FRAMES = 420


def path(turn_at: int, turn_rad: float, pause: slice | None = None) -> NDArray[np.float64]:
    """Return the places (T, 2) of a fish that swims half a pixel a frame, turns once, and may pause."""
    heading = np.where(np.arange(FRAMES) < turn_at, 0.0, turn_rad)
    speed = np.full(FRAMES, 0.5)
    if pause is not None:
        speed[pause] = 0.0
    steps = speed[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    return 100.0 + np.cumsum(steps, axis=0)


def tank(*paths: NDArray[np.float64]) -> Tank:
    places = np.stack(paths, axis=1)
    tracks = Tracks(places, 1 / 30, true_px=places)
    floor_rgb = np.full((320, 320, 3), 90, np.uint8)
    return Tank("paper-c", 0, floor_rgb, GapTask(tracks, 25, 450.0, sees_mates=True))


def turned(made: Tank) -> Gap | None:
    return turning_gap(made.task.tracks, made.task.open_gaps)


def test_the_gap_with_a_turn_is_of_the_fish_that_turns_most_while_it_moves() -> None:
    hovers, turns, straight = path(220, 3.0, slice(190, 250)), path(220, 1.6), path(220, 0.5)
    found = turned(tank(hovers, turns, straight))
    assert found is not None
    assert (found.target, found.count) == (1, 200)
    assert found.first < 220 < found.first + 200
    assert turned(tank(hovers, straight)) is None


def test_the_usual_gap_has_the_median_error() -> None:
    # The predictions of one that keeps the last place are off by as far as each fish swims.
    made = tank(*(path(0, 0.0) * np.array([scale, 1.0]) for scale in (1.0, 2.0, 3.0)))
    found = usual_gap(made, 50, "fish_hold")
    assert found is not None
    assert (found.target, found.count) == (1, 50)
    assert usual_gap(made, 60, "fish_hold") is None


@pytest.mark.parametrize(("figure", "turn_words"), [(3, ""), (4, ", turns 92°")])
def test_the_lost_piece_and_its_prediction_are_in_the_picture(figure: int, turn_words: str) -> None:
    words, picture = tank(path(220, 1.6)).cell(figure, Gap(0, 150, 200), ("fish_hold",))
    # 70 frames ahead, 130 across.
    off_px = 0.5 * np.hypot(*(70 * np.array([1, 0]) + 130 * np.array([np.cos(1.6), np.sin(1.6)])))
    assert words == f"{figure}: paper-c, 200 lost{turn_words}; {off_px:.1f} px off"
    for colour in (marks.OBSERVED, marks.TRUTH, marks.ESTIMATE):
        assert (picture == colour).all(axis=2).sum() > 20
