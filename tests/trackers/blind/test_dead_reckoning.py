"""Blind trackers of one target."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.optics import PinholeCamera, look_down_pose, project
from trackers import registry
from trackers.blind.dead_reckoning import (
    AheadParameters,
    Below,
    Carried,
    CarriedParameters,
    StraightAhead,
    StraightParameters,
    TurningParameters,
)
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.protocols import TargetState
from trackers.types import CameraModel, EgoPose, Observation

CAMERA = PinholeCamera(160, 120, 140.0)
RNG = np.random.default_rng(0)
NO_PICTURE = np.empty((0, 0, 3), np.uint8)
BOX = np.zeros(4)
PLACE_M, VELOCITY_MPS = np.array([7.0, -4.0, 0.7]), np.array([8.0, 3.0, 0.0])


def seen_from(pose: NDArray[np.float64] | None, time_s: float) -> Observation:
    model = CameraModel(CAMERA.width_px, CAMERA.height_px, CAMERA.focal_px)
    return Observation(NO_PICTURE, time_s, model, ego=None if pose is None else EgoPose(pose))


def state_from(pose: NDArray[np.float64]) -> TargetState:
    return TargetState((PLACE_M - pose[:3, 3]) @ pose[:3, :3], VELOCITY_MPS @ pose[:3, :3])


def pixel(point_m: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    return project(CAMERA, pose, point_m)[0]


START = look_down_pose(np.array([2.0, 1.0, 60.0]), 0.3, 0.1, -0.2)
MOVED = look_down_pose(np.array([12.0, -5.0, 64.0]), 1.1, -0.3, 0.25)


def answer(parameters: CarriedParameters) -> NDArray[np.float64]:
    """Return the position two seconds after the exit, with one picture in between."""
    tracker = Carried(parameters, RNG)
    tracker.initialise(seen_from(START, 1.0), BOX)
    tracker.set_state(seen_from(START, 1.0), state_from(START))
    assert tracker.update(seen_from(START, 1.0)).position_px == pytest.approx(pixel(PLACE_M, START))
    tracker.update(seen_from(MOVED, 3.0))
    return tracker.update(seen_from(MOVED, 3.0)).position_px


def test_it_is_carried_over_the_ground_as_far_as_the_camera_goes() -> None:
    assert answer(CarriedParameters()) == pytest.approx(pixel(PLACE_M + np.array([10.0, -6.0, 0.0]), MOVED))


def test_it_drives_straight_on_whatever_the_camera_does() -> None:
    assert answer(StraightParameters()) == pytest.approx(pixel(PLACE_M + 2.0 * VELOCITY_MPS, MOVED))


def test_shares_of_both_add_up() -> None:
    place_m = PLACE_M + 0.5 * np.array([10.0, -6.0, 0.0]) + 0.25 * 2.0 * VELOCITY_MPS
    assert answer(CarriedParameters(0.5, 0.25, 0.0)) == pytest.approx(pixel(place_m, MOVED))


def test_it_turns_with_the_camera() -> None:
    """On a circle, below a camera that turns at the same rate, it stays on the target; the straight one does not."""
    rate_rad_s, speed_mps, dt_s = 0.4, 8.0, 1 / 15
    error_m = {}
    for parameters in (StraightParameters(), TurningParameters()):
        tracker = Carried(parameters, RNG)
        for k in range(46):
            angle = rate_rad_s * k * dt_s
            place_m = speed_mps / rate_rad_s * np.array([np.sin(angle), 1 - np.cos(angle), 0.0])
            pose = look_down_pose(np.array([0.0, 0.0, 60.0]), angle, 0.1, -0.1)
            if k == 0:
                state = TargetState((place_m - pose[:3, 3]) @ pose[:3, :3], np.array([speed_mps, 0, 0]) @ pose[:3, :3])
                tracker.set_state(seen_from(pose, 0.0), state)
            answer_px = tracker.update(seen_from(pose, k * dt_s)).position_px
            error_m[parameters.turns] = np.linalg.norm(answer_px - pixel(place_m, pose)) * 60.0 / CAMERA.focal_px
    assert error_m[1.0] < 1.0
    assert error_m[0.0] > 10.0


def test_below_is_where_a_plumb_line_meets_the_ground() -> None:
    for pose in (START, MOVED):
        estimate = Below(registry.NoParameters(), RNG).update(seen_from(pose, 0.0))
        assert estimate.position_px == pytest.approx(pixel(pose[:3, 3] * [1.0, 1.0, 0.0], pose))


def test_without_instruments_it_stays_where_it_was_in_the_picture() -> None:
    tracker = Carried(CarriedParameters(), RNG)
    tracker.set_state(seen_from(None, 0.0), TargetState(np.array([6.0, -3.0, 60.0]), np.zeros(3)))
    assert tracker.update(seen_from(None, 2.0)).position_px == pytest.approx([80 + 14.0, 60 - 7.0])
    assert Below(registry.NoParameters(), RNG).update(seen_from(None, 0.0)).position_px == pytest.approx([80, 60])


@pytest.mark.parametrize(
    "name", [name for name, entry in registry.entries().items() if entry.role == "blind" and not entry.follows_many]
)
def test_answers_are_finite_however_the_camera_is_held(name: str) -> None:
    rng = np.random.default_rng(5)
    tracker = registry.entry(name).create(rng)
    tracker.set_state(seen_from(START, 0.0), state_from(START))  # type: ignore[attr-defined]
    for k in range(200):
        pose = look_down_pose(rng.normal(0, 100, 3), *rng.uniform(-np.pi, np.pi, 3))
        assert np.isfinite(tracker.update(seen_from(pose, 0.1 * k)).position_px).all()


def test_it_says_nothing_before_it_has_a_state() -> None:
    assert np.isnan(Carried(CarriedParameters(), RNG).update(seen_from(START, 0.0)).position_px).all()


def test_it_is_always_as_far_straight_ahead() -> None:
    camera = CameraModel(640, 480, 500.0, baseline_m=0.12)
    tracker = StraightAhead(AheadParameters(2.5), np.random.default_rng(0))
    estimate = tracker.update(Observation(np.empty((0, 0, 3), np.uint8), 0.0, camera))
    assert estimate.depth_m is not None
    assert Mounting.level(1.2).place_at(estimate.position_px, estimate.depth_m, camera) == pytest.approx(
        [2.5, 0.0, 1.2]
    )
