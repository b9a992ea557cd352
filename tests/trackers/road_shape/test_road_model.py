"""The road: splines, the line at its end, and its shape."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tests.fakes import CAMERA, ROAD_WIDTH_M, DrawnTown, bent_road, look_down, straight_road
from trackers.road_shape.background_motion import STILL, measured_motion
from trackers.road_shape.road_lines import LineFinder, RoadSearch, line_positions, line_profile
from trackers.road_shape.road_model import (
    NewRoad,
    NewRoadModel,
    RoadCurve,
    RoadEnd,
    RoadModel,
    evaluate_spline,
    fit_cubic_spline,
    last_direction,
)
from trackers.types import EgoPose


@settings(deadline=None)
@given(st.integers(3, 9), st.integers(0, 10_000))
def test_is_scipys_with_the_same_end_curvatures(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    knots = np.cumsum(rng.uniform(5, 30, count)) - 40
    values = rng.uniform(-50, 50, count)
    pieces = fit_cubic_spline(knots, values)
    ends = tuple((2, float(curvature)) for curvature in (2 * pieces[0, 1], 2 * pieces[-1, 1]))
    reference = CubicSpline(knots, values, bc_type=ends)
    at = np.linspace(knots[0] - 30, knots[-1] + 30, 80)
    got, slopes = evaluate_spline(knots, pieces, at)
    scale = np.abs(reference(at)).max() + 1
    np.testing.assert_allclose(got, reference(at), atol=1e-9 * scale)
    np.testing.assert_allclose(slopes, reference(at, 1), atol=1e-9 * scale)
    # The ends are parabolas, so the curvature goes on unchanged outside.
    assert abs(pieces[0, 0]) < 1e-12
    assert abs(pieces[-1, 0]) < 1e-12


def test_a_parabola_is_met_exactly_and_goes_on_outside() -> None:
    knots = np.array([-20.0, 0.0, 7.0, 30.0])
    pieces = fit_cubic_spline(knots, 3 + 0.5 * knots + 0.01 * knots**2)
    at = np.array([-100.0, -3.0, 90.0])
    values, slopes = evaluate_spline(knots, pieces, at)
    np.testing.assert_allclose(values, 3 + 0.5 * at + 0.01 * at**2)
    np.testing.assert_allclose(slopes, 0.5 + 0.02 * at)


def test_two_points_are_a_straight_line() -> None:
    knots = np.array([0.0, 4.0])
    values, slopes = evaluate_spline(knots, fit_cubic_spline(knots, np.array([1.0, 3.0])), np.array([-2.0, 2.0, 10.0]))
    np.testing.assert_allclose(values, [0.0, 2.0, 6.0])
    np.testing.assert_allclose(slopes, 0.5)


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


HEIGHT_M = 60.0
PX_PER_M = CAMERA.focal_px / HEIGHT_M
TOWN_CAR_PX = 4.5 * PX_PER_M
CENTRE = 0.5 * np.array([CAMERA.width_px, CAMERA.height_px])


def grey_at(town: DrawnTown, pose: NDArray[np.float64]) -> NDArray[np.uint8]:
    frame = town.frame(pose, np.array([1e4, 1e4]), 0.0, 0.0)
    return cv2.cvtColor(frame.observation.image_rgb, cv2.COLOR_RGB2GRAY)


def pixels(points_m: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where ground points (M, 2) are seen, in pixels from the image centre."""
    camera_m = (np.column_stack([points_m, np.zeros(len(points_m))]) - pose[:3, 3]) @ pose[:3, :3]
    return camera_m[:, :2] / camera_m[:, 2:] * CAMERA.focal_px


def traced(
    road_m: NDArray[np.float64], pose: NDArray[np.float64], car_m: NDArray[np.float64], bare: bool = False
) -> tuple[RoadCurve | None, RoadModel, DrawnTown]:
    town = DrawnTown(road_m, 240.0, np.random.default_rng(0), bare=bare)
    model = RoadModel(RoadSearch(), TOWN_CAR_PX, np.random.default_rng(1))
    return model.update(grey_at(town, pose), STILL, pixels(car_m[None], pose)[0], None), model, town


@pytest.mark.heavy
@pytest.mark.parametrize("yaw_rad", [0.0, 0.4, np.pi / 4, 1.2, np.pi / 2, 2.5])
def test_a_straight_road_is_found_whatever_its_direction(yaw_rad: float) -> None:
    pose = look_down(0.0, 0.0, HEIGHT_M, yaw_rad)
    curve, _, _ = traced(straight_road(), pose, np.array([3.0, -2.0]))
    assert curve is not None
    assert curve.half_width_px == pytest.approx((0.5 * ROAD_WIDTH_M - 0.4) * PX_PER_M, rel=0.06)
    on_road = pixels(np.column_stack([np.linspace(-35, 35, 30), np.zeros(30)]), pose)
    heading = np.arctan2(*(on_road[-1] - on_road[0])[::-1])
    offset, direction = curve.offset_and_direction(on_road, np.full(30, heading))
    inside = (np.abs(on_road) < CENTRE).all(axis=1)
    assert np.abs(offset[inside]).max() < 0.35 * PX_PER_M
    assert np.abs(direction[inside] - heading).max() < 0.1
    # Up to 15 m beyond the border: extrapolation magnifies what the last points are off.
    assert np.abs(offset).max() < 2.0 * PX_PER_M
    assert np.abs(direction - heading).max() < 0.2


def test_the_direction_is_the_branch_nearer_to_the_heading() -> None:
    pose = look_down(0.0, 0.0, HEIGHT_M, 0.0)
    curve, _, _ = traced(straight_road(), pose, np.array([0.0, -2.0]))
    assert curve is not None
    headings = np.random.default_rng(0).uniform(-9, 9, 50)
    _, direction = curve.offset_and_direction(np.zeros((50, 2)), headings)
    assert np.abs(direction - headings).max() <= np.pi / 2 + 1e-9


def test_a_bend_is_followed_and_goes_on_outside() -> None:
    road_m = bent_road(45.0)
    pose = look_down(15.0, 5.0, HEIGHT_M, 0.0)
    curve, _, _ = traced(road_m, pose, np.array([8.0, -1.0]))
    assert curve is not None
    line = pixels(road_m, pose)
    inside = line[(np.abs(line) < CENTRE).all(axis=1)]
    offset, _ = curve.offset_and_direction(inside, np.zeros(len(inside)))
    assert np.abs(offset).max() < 0.8 * PX_PER_M
    just_outside = line[(np.abs(line) > CENTRE).any(axis=1) & (np.abs(line) < CENTRE + 50).all(axis=1)]
    assert len(just_outside) > 5
    offset, _ = curve.offset_and_direction(just_outside, np.zeros(len(just_outside)))
    assert np.abs(offset).max() < 3.0 * PX_PER_M


def test_it_grows_into_what_is_newly_seen_without_the_car_in_view() -> None:
    road_m = bent_road(45.0)
    pose = look_down(-10.0, 0.0, HEIGHT_M, 0.0)
    curve, model, town = traced(road_m, pose, np.array([-10.0, -2.0]))
    car = pixels(np.array([[-10.0, -2.0]]), pose)[0]
    for step in range(1, 25):
        following = look_down(-10.0 + 1.6 * step, 0.5 * step, HEIGHT_M, 0.0)
        motion = measured_motion(EgoPose(pose), EgoPose(following), CAMERA)
        curve = model.update(grey_at(town, following), motion, car, np.pi / 2)
        pose, car = following, motion.move(car)
    assert car[1] > CENTRE[1]
    ahead = model.update(grey_at(town, pose), STILL, pixels(road_m[300:301], pose)[0], None)
    assert curve is not None
    assert ahead is not None
    line = pixels(road_m[260:330], pose)
    seen = line[(np.abs(line) < CENTRE - 20).all(axis=1)]
    offset, _ = ahead.offset_and_direction(seen, np.zeros(len(seen)))
    assert np.abs(offset).max() < 0.3 * PX_PER_M


def test_without_lines_there_is_no_road() -> None:
    pose = look_down(0.0, 0.0, HEIGHT_M, 0.0)
    curve, model, _ = traced(straight_road(), pose, np.array([0.0, -2.0]), bare=True)
    assert curve is None
    uniform = np.full((CAMERA.height_px, CAMERA.width_px), 80, np.uint8)
    assert model.update(uniform, STILL, np.zeros(2), 0.3) is None


def test_a_drawn_line_is_where_it_was_drawn() -> None:
    grey = np.full((60, 80), 90, np.uint8)
    # Columns 50 and 51: the line's middle is at x = 52 - 1 = 51.
    grey[:, 50:52] = 220
    profile = line_profile(grey, np.array([40.0, 30.0]), -np.pi / 2, 20, 3, 5)
    found = line_positions(profile, -20.0, 20.0, 20.0)
    np.testing.assert_allclose(found, [11.0], atol=0.6)
    mirrored = line_positions(line_profile(grey, np.array([40.0, 30.0]), np.pi / 2, 20, 3, 5), -20.0, 20.0, 20.0)
    np.testing.assert_allclose(mirrored, -found, atol=1e-9)


def test_outside_the_picture_nothing_is_a_line() -> None:
    grey = np.random.default_rng(0).integers(0, 255, (40, 40)).astype(np.uint8)
    assert line_profile(grey, np.array([-200.0, 20.0]), 0.0, 10, 3, 3).tolist() == [0.0] * 21
