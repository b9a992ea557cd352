"""The traced road against the road that was drawn."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fakes import CAMERA, ROAD_WIDTH_M, DrawnTown, bent_road, look_down, straight_road
from trackers.road_shape.background_motion import STILL, measured_motion
from trackers.road_shape.road_lines import RoadSearch, line_positions, line_profile
from trackers.road_shape.road_model import RoadCurve, RoadModel
from trackers.types import EgoPose

HEIGHT_M = 60.0
PX_PER_M = CAMERA.focal_px / HEIGHT_M
CAR_PX = 4.5 * PX_PER_M
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
    model = RoadModel(RoadSearch(), CAR_PX, np.random.default_rng(1))
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
