"""Measured motion of the ground and the car's state, against direct computation."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import intersect_plane, look_down_pose, project
from trackers.particle_filter import Posterior
from trackers.road_shape.background_motion import STILL, PictureMotion, measured_motion
from trackers.road_shape.car_state import HEADING, POSITION, SPEED, car_estimate, initial_states, move_on
from trackers.types import CameraModel, EgoPose

CAMERA = CameraModel(320, 240, 400.0)
PINHOLE = CameraModel(320, 240, 400.0)


def test_measured_motion_takes_ground_points_along() -> None:
    before = look_down_pose(np.array([3.0, -2.0, 60.0]), 0.3, 0.1, -0.05)
    after = look_down_pose(np.array([4.5, -1.0, 61.0]), 0.36, -0.08, 0.12)
    motion = measured_motion(EgoPose(before), EgoPose(after), CAMERA)
    pixels = np.random.default_rng(0).uniform([-200, -200], [500, 400], (50, 2))
    ground = np.column_stack([intersect_plane(PINHOLE, before, pixels, 0.0), np.zeros(50)])
    expected, _ = project(PINHOLE, after, ground)
    np.testing.assert_allclose(motion.move(pixels - PINHOLE.centre_px) + PINHOLE.centre_px, expected, atol=1e-6)


def test_a_level_camera_moves_the_picture_as_the_paper_has_it() -> None:
    before = look_down_pose(np.array([0.0, 0.0, 50.0]), 0.0, 0.0, 0.0)
    # 2 m ahead (to the top of the picture), 1 m to the left, turned clockwise as seen from above by 0.1.
    after = look_down_pose(np.array([2.0, 1.0, 50.0]), -0.1, 0.0, 0.0)
    measured = measured_motion(EgoPose(before), EgoPose(after), CAMERA)
    shift = PictureMotion(np.array([-8.0, -16.0]), 0.0)
    turn = PictureMotion(np.zeros(2), 0.1)
    points = np.random.default_rng(1).uniform(-150, 150, (20, 2))
    np.testing.assert_allclose(measured.move(points), turn.move(shift.move(points)), atol=1e-6)


def test_without_a_pose_the_motion_is_zero() -> None:
    pose = EgoPose(look_down_pose(np.array([0.0, 0.0, 50.0]), 0.0, 0.0, 0.0))
    assert measured_motion(None, pose, CAMERA) is STILL
    assert measured_motion(pose, None, CAMERA) is STILL


def test_beyond_the_horizon_nothing_is_infinite() -> None:
    flat = look_down_pose(np.array([0.0, 0.0, 50.0]), 0.0, 0.0, 0.0)
    tilted = look_down_pose(np.array([0.0, 0.0, 50.0]), 0.0, 1.4, 0.0)
    moved = measured_motion(EgoPose(flat), EgoPose(tilted), CAMERA).move(np.array([[0.0, 3000.0], [0.0, -3000.0]]))
    assert np.isfinite(moved).all()


def test_the_car_moves_by_its_velocity_and_then_with_the_picture() -> None:
    states = np.array([[10.0, -5.0, 4.0, 0.5], [0.0, 0.0, 0.0, 3.0]])
    motion = PictureMotion(np.array([3.0, -2.0]), 0.2)
    moved = move_on(states, motion, 0.0, np.random.default_rng(0))
    c, s = np.cos(0.2), np.sin(0.2)
    for before, after in zip(states, moved, strict=True):
        x, y = before[POSITION] + before[SPEED] * np.array([np.cos(before[HEADING]), np.sin(before[HEADING])])
        np.testing.assert_allclose(after[POSITION], [c * x + s * y - 3.0, -s * x + c * y + 2.0], atol=1e-9)
        assert after[SPEED] == pytest.approx(before[SPEED])
        assert np.cos(after[HEADING] - before[HEADING] + 0.2) == pytest.approx(1.0)


def test_speed_is_a_plain_random_walk_through_zero_too() -> None:
    states = initial_states(4000, np.zeros(2), 40.0, np.random.default_rng(1))
    states[:2000, SPEED] = 0.0
    change = (move_on(states, STILL, 1.5, np.random.default_rng(2)) - states)[:, SPEED]
    for part in (change[:2000], change[2000:]):
        assert part.mean() == pytest.approx(0.0, abs=0.1)
        assert part.std() == pytest.approx(1.5, rel=0.06)


def test_the_estimate_is_the_weighted_mean_and_knows_the_share_in_view() -> None:
    states = np.array([[0.0, 0.0, 1.0, 0.1], [400.0, 0.0, 1.0, -0.1]])
    posterior = Posterior(states, np.array([0.75, 0.25]), 0.0, False)
    estimate = car_estimate(posterior, CAMERA, np.array([20.0, 10.0]))
    np.testing.assert_allclose(estimate.position_px, [260.0, 120.0])
    np.testing.assert_allclose(estimate.box_xyxy, [250.0, 115.0, 270.0, 125.0])
    assert estimate.in_view_probability == 0.75
