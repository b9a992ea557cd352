"""Motion of the background: measured, by flow, and filtered."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from sim.optics import PinholeCamera, intersect_plane, look_down_pose, project
from trackers.particle_filter import Posterior
from trackers.road_shape.background_motion import (
    STILL,
    BackgroundMotionFilter,
    BackgroundMotionParameters,
    PictureMotion,
    find_corners,
    flow_misfits,
    follow_corners,
    measured_motion,
)
from trackers.road_shape.colour_pf import HEADING, POSITION, SPEED, car_estimate, initial_states, move_on
from trackers.types import CameraModel, EgoPose

CENTRE = np.array([160.0, 120.0])


@pytest.fixture(scope="module")
def ground() -> NDArray[np.uint8]:
    """Return a textured ground, larger than the picture, which is cut out of its middle."""
    rng = np.random.default_rng(0)
    blocks = cv2.resize(rng.integers(0, 256, (60, 70), dtype=np.uint8), (560, 480), interpolation=cv2.INTER_NEAREST)
    return cv2.GaussianBlur(blocks, (5, 5), 0)


def picture(ground: NDArray[np.uint8], motion: PictureMotion) -> NDArray[np.uint8]:
    """Return the picture after ``motion`` of the camera, drawn by its definition alone, pixel centre by pixel centre.

    The camera moves by (Vx, Vy) over the picture and turns by ω clockwise as seen: a ground point at p moves to
    ``Rot(-ω) p - V``, so what is now at q was at ``Rot(ω) (q + V)``.
    """
    columns, rows = np.meshgrid(np.arange(320) + 0.5, np.arange(240) + 0.5)
    x, y = columns - CENTRE[0] + motion.translation_px[0], rows - CENTRE[1] + motion.translation_px[1]
    c, s = np.cos(motion.rotation_rad), np.sin(motion.rotation_rad)
    was_x, was_y = c * x - s * y + 280.0 - 0.5, s * x + c * y + 240.0 - 0.5
    return cv2.remap(ground, was_x.astype(np.float32), was_y.astype(np.float32), cv2.INTER_CUBIC)


MOTIONS = [
    PictureMotion(np.array([6.0, 0.0]), 0.0),
    PictureMotion(np.array([-6.0, 0.0]), 0.0),
    PictureMotion(np.array([0.0, 6.0]), 0.0),
    PictureMotion(np.array([0.0, -6.0]), 0.0),
    PictureMotion(np.zeros(2), 0.03),
    PictureMotion(np.zeros(2), -0.03),
    PictureMotion(np.array([4.0, -3.0]), 0.02),
]


def corner_flow(ground: NDArray[np.uint8], motion: PictureMotion) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    before = picture(ground, STILL)
    corners = find_corners(before, 100, 24)
    return follow_corners(before, picture(ground, motion), corners, corners)


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_true_motion_explains_the_flow_and_no_other_sign_does(
    ground: NDArray[np.uint8], motion: PictureMotion
) -> None:
    corners, flow = corner_flow(ground, motion)
    assert len(corners) > 60
    true = np.array([*motion.translation_px, motion.rotation_rad])
    signs = np.array(np.meshgrid([1, -1], [1, -1], [1, -1])).reshape(3, -1).T
    candidates = np.unique(signs * true, axis=0)
    misfits = flow_misfits(candidates, corners - CENTRE, flow) / len(corners)
    right = (candidates == true).all(axis=1)
    assert misfits[right].item() < 0.35
    assert (misfits[~right] > 1.5).all()


@pytest.mark.parametrize("motion", MOTIONS)
def test_move_takes_corners_to_where_they_are_found(ground: NDArray[np.uint8], motion: PictureMotion) -> None:
    corners, flow = corner_flow(ground, motion)
    moved = motion.move(corners - CENTRE) + CENTRE
    assert np.median(np.hypot(*(moved - corners - flow).T)) < 0.15


def test_a_good_guess_finds_what_is_far(ground: NDArray[np.uint8]) -> None:
    motion = PictureMotion(np.array([70.0, -40.0]), 0.0)
    before, after = picture(ground, STILL), picture(ground, motion)
    corners = find_corners(before, 100, 24)
    moved = corners + np.array([-70, 40])
    stays = ((moved > 20) & (moved < [300, 220])).all(axis=1)
    followed, flow = follow_corners(before, after, corners[stays], corners[stays] + np.array([-55, 30]))
    assert np.median(np.hypot(*(flow - [-70, 40]).T)) < 0.3
    assert len(followed) > 15


def test_corners_keep_off_the_border(ground: NDArray[np.uint8]) -> None:
    corners = find_corners(picture(ground, STILL), 200, 40)
    assert len(corners) > 30
    assert (corners >= 40).all()
    assert (corners <= [280, 200]).all()


def test_misfit_is_the_sum_of_distances() -> None:
    rng = np.random.default_rng(1)
    motions, corners, flow = rng.normal(size=(5, 3)), rng.normal(0, 50, (7, 2)), rng.normal(size=(7, 2))
    for (vx, vy, omega), misfit in zip(motions, flow_misfits(motions, corners, flow), strict=True):
        model = np.column_stack([-vx + omega * corners[:, 1], -vy - omega * corners[:, 0]])
        assert misfit == pytest.approx(np.linalg.norm(flow - model, axis=1).sum())


def test_the_filter_finds_a_steady_motion(ground: NDArray[np.uint8]) -> None:
    step = PictureMotion(np.array([2.5, -1.5]), 0.006)
    parameters = BackgroundMotionParameters(particles=1000, translation_noise_px=2.0, rotation_noise_rad=0.004)
    current = STILL
    first = cv2.cvtColor(picture(ground, current), cv2.COLOR_GRAY2RGB)
    motion_filter = BackgroundMotionFilter(parameters, first, np.random.default_rng(2))
    errors = []
    for _ in range(12):
        # Two motions in turn are Rot(-ω)(Rot(-ω₀) p - V₀) - V.
        translation = step.move(-current.translation_px) * -1.0
        current = PictureMotion(translation, current.rotation_rad + step.rotation_rad)
        found = motion_filter.update(cv2.cvtColor(picture(ground, current), cv2.COLOR_GRAY2RGB))
        shift = found.translation_px - step.translation_px
        errors.append([*shift, 100 * (found.rotation_rad - step.rotation_rad)])
    assert np.abs(np.median(errors[2:], axis=0)).max() < 0.6


def test_a_picture_without_corners_leaves_the_walk_alone() -> None:
    grey = np.full((240, 320, 3), 90, np.uint8)
    motion_filter = BackgroundMotionFilter(BackgroundMotionParameters(), grey, np.random.default_rng(3))
    motion = motion_filter.update(grey)
    assert np.isfinite([*motion.translation_px, motion.rotation_rad]).all()
    assert np.hypot(*motion.translation_px) < 1.0


CAMERA = CameraModel(320, 240, 400.0)
PINHOLE = PinholeCamera(320, 240, 400.0)


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
