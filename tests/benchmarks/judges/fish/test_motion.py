"""Statistics of motion, against tracks whose statistics are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.judges.fish.motion import motion_scores


def motion(position_px: np.ndarray, body_px: float = 35.0) -> dict[str, Any]:
    return {each.metric.removeprefix("motion_"): each.value for each in motion_scores(position_px, body_px)}


def circle(turn_rad: float, speed_px: float = 2.0, frames: int = 400) -> np.ndarray:
    """Return a track (T, 1, 2) that turns by the same angle on each frame."""
    heading = turn_rad * np.arange(frames)
    steps = speed_px * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])[:, None]


@given(st.floats(-0.3, 0.3), st.floats(0.1, 20.0))
@settings(max_examples=30, deadline=None)
def test_a_circle_turns_as_it_does(turn_rad, speed_px):
    found = motion(circle(turn_rad, speed_px))
    for percentile in (5, 50, 95):
        assert found[f"step_p{percentile}_any"] == pytest.approx(speed_px)
    assert found["turn_5"] == pytest.approx(np.rad2deg(abs(5 * turn_rad)), abs=1e-6)
    for lag in (5, 50, 200):
        assert found[f"heading_{lag}"] == pytest.approx(np.cos(lag * turn_rad), abs=1e-9)
        assert found[f"velocity_{lag}"] == pytest.approx(np.cos(lag * turn_rad), abs=1e-9)
    chord = 1.0 if abs(turn_rad) < 1e-9 else abs(np.sin(25 * turn_rad) / (50 * np.sin(0.5 * turn_rad)))
    assert found["straightness_50"] == pytest.approx(chord, abs=1e-9)


def test_a_random_walk_is_as_straight_as_theory_says():
    rng = np.random.default_rng(0)
    found = motion(np.cumsum(rng.normal(size=(4000, 20, 2)), axis=0))
    # Rayleigh means of the distance after n steps and of each step: sqrt(n) / n.
    assert found["straightness_100"] == pytest.approx(0.1, rel=0.05)
    assert found["heading_50"] == pytest.approx(0.0, abs=0.02)
    assert found["speed_50"] == pytest.approx(0.0, abs=0.02)


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_unmeasured_frames_change_little_and_never_count_as_steps(seed):
    rng = np.random.default_rng(seed)
    whole = circle(0.01, 3.0, 1500)
    holed = whole.copy()
    for first in rng.integers(0, 1400, 5):
        holed[first : first + 20] = np.nan
    one, other = motion(whole), motion(holed)
    for name in ("step_p50_any", "turn_5", "heading_50", "straightness_50"):
        assert other[name] == pytest.approx(one[name], rel=1e-6)


def test_walls_and_meetings_are_those_of_the_positions():
    frames = np.arange(401.0)
    along = np.column_stack([frames, np.full(401, 10.0)])
    box = np.column_stack([frames, np.where(frames < 100, 0.0, 200.0)])
    apart = motion(np.stack([along, box], axis=1), 25.0)
    # Within 12.5 px while the second is at the lower wall: a quarter of the time.
    assert apart["meetings_any"] == pytest.approx(100 / 401)
    # Two that swim 10 px from the lower wall but for their ends, and one along the walls.
    assert motion(np.stack([along, along, box], axis=1), 25.0)["wall_p50_any"] == 10.0
    assert "meetings_any" not in motion(along[:, None], 25.0)


def test_meetings_go_on_where_a_tracker_lost_a_fish():
    two = np.zeros((100, 2, 2))
    two[:, 0, 0] = np.arange(100)
    two[:, 1] = two[:, 0] + [0.0, 5.0]
    two[30:60, 1] = np.nan
    assert motion(two)["meetings_any"] == 1.0


def test_short_tracks_have_no_statistics_of_long_gaps():
    found = motion(circle(0.1, 2.0, 120))
    assert "straightness_100" in found
    assert "straightness_200" not in found
