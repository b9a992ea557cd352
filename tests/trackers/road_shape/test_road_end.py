"""The filter of newly seen road against the paper's equations, written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from trackers.road_shape.road_lines import LineFinder, RoadSearch
from trackers.road_shape.road_model import NewRoad, NewRoadModel, RoadEnd, fit_cubic_spline, last_direction

CAR_PX = 40.0


def test_the_weight_is_exp_of_minus_the_squared_distances_to_the_nearest_edges() -> None:
    rng = np.random.default_rng(0)
    ahead = (10.0, 10.0, 25.0, 25.0)
    edges = (rng.normal(0, 3, 2), np.empty(0), rng.normal(0, 3, 3), np.array([40.0]))
    curvatures = rng.normal(0, 0.01, (50, 1))
    model = NewRoadModel(0.0, CAR_PX, 0.04)
    got = model.log_weights(curvatures, NewRoad(15.0, ahead, edges, 8.0))
    for (curvature,), log_weight in zip(curvatures, got, strict=True):
        d = 0.0
        for y, found in zip(ahead, edges, strict=True):
            misses = [min(abs(curvature * y * y / 2 - edge), 8.0) for edge in found]
            d += min(misses) ** 2 if misses else 0.0
        assert log_weight == pytest.approx(-d)


@pytest.mark.parametrize("length_px", [20.0, 5.0])
def test_curvature_is_a_walk_over_the_length_of_new_road(length_px: float) -> None:
    model = NewRoadModel(0.0, CAR_PX, 0.04)
    states = np.full((20000, 1), 0.003)
    moved = model.predict(states, NewRoad(length_px, (), (), 8.0), np.random.default_rng(1))
    assert moved.mean() == pytest.approx(0.003, abs=1e-4)
    assert moved.std() == pytest.approx(0.04 / 20.0 * np.sqrt(length_px / 20.0), rel=0.03)


@pytest.mark.parametrize("turn_rad", [0.0, 1.3, -2.6])
def test_the_last_piece_leaves_its_knot_as_the_spline_does(turn_rad: float) -> None:
    y = np.array([0.0, 31.0, 70.0, 102.0])
    x = np.array([0.0, 4.0, 15.0, 0.0])
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    knots = np.stack([c * y - s * x, s * y + c * x], axis=1)
    # x = 0 at both ends: the chord is the axis, as for the tracker.
    pieces = fit_cubic_spline(y, x)
    reference = CubicSpline(y, x, bc_type=((2, 2 * pieces[0, 1]), (2, 2 * pieces[-1, 1])))
    expected = turn_rad + np.arctan(reference(y[-1], 1))
    assert np.angle(np.exp(1j * (last_direction(knots) - expected))) == pytest.approx(0.0, abs=1e-6)


def arc_picture(radius_px: float) -> np.ndarray:
    """Return a picture (240, 320) of a road of two bright lines, 50 px apart, on an arc from its left to its right."""
    rows, columns = np.mgrid[0:240, 0:320] + 0.5
    away = np.hypot(columns - 0.0, rows - 120.0 - radius_px) - radius_px
    return np.where(np.abs(np.abs(away) - 25.0) < 2.0, 220, 80).astype(np.uint8)


@pytest.mark.parametrize("step_px", [4.0, 20.0])
def test_an_end_follows_a_bend_however_far_each_frame_shows_it(step_px: float) -> None:
    radius_px = 300.0
    finder = LineFinder(arc_picture(radius_px), CAR_PX, RoadSearch())
    end = RoadEnd(0.0, CAR_PX, np.random.default_rng(2))
    knots = np.array([[-160.0, 0.0], [-150.0, 10.0**2 / 2 / radius_px]])
    end.turn(knots)
    for _ in range(int(200 / step_px)):
        knot = end.advance(finder, knots[-1], step_px, 25.0)
        if knot is not None:
            knots = np.concatenate([knots, knot[None]])
            end.turn(knots)
    assert len(knots) >= 6
    away = np.hypot(knots[:, 0] + 160.0, knots[:, 1] - radius_px) - radius_px
    assert np.abs(away).max() < 1.5
    tip = end.tip_px(knots[-1])
    assert np.hypot(tip[0] + 160.0, tip[1] - radius_px) == pytest.approx(radius_px, abs=3.0)


def test_an_end_without_edges_sets_no_knot_and_is_lost_in_the_end() -> None:
    finder = LineFinder(np.full((240, 320), 90, np.uint8), CAR_PX, RoadSearch())
    end = RoadEnd(0.0, CAR_PX, np.random.default_rng(3))
    lost = []
    for _ in range(15):
        assert end.advance(finder, np.array([-160.0, 0.0]), 20.0, 25.0) is None
        lost.append(end.lost)
    assert not lost[0]
    assert lost[-1]


def test_room_ends_where_both_lines_leave_the_picture() -> None:
    finder = LineFinder(np.zeros((240, 320), np.uint8), CAR_PX, RoadSearch())
    margin_px = 0.22 * CAR_PX + 3 + 1
    for quarter in range(-2, 4):
        half_px = 120 if quarter % 2 else 160
        assert finder.room_px(np.zeros(2), quarter * np.pi / 2, 25.0) == pytest.approx(half_px - margin_px)
    # Diagonally, the line at (17.7, -17.7) meets the right border, and the other one the lower border sooner.
    across = 25.0 / np.sqrt(2)
    assert finder.room_px(np.zeros(2), np.pi / 4, 25.0) == pytest.approx((120 - margin_px + across) * np.sqrt(2))
    assert finder.room_px(np.array([0.0, 200.0]), 0.0, 25.0) == 0.0
