"""The tracker against a drawn sphere of noise on which a disc moves, seen by a camera that turns and zooms."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from sim.pose import rotation_by
from trackers.controllers.ptz import LeadPtz, LeadPtzParameters
from trackers.kernels.boxes import box_around
from trackers.registry import entry
from trackers.types import CameraModel, EgoPose, Estimate, Observation

WIDTH, HEIGHT, RATE_HZ, RADIUS = 160, 120, 10.0, 0.012
_WORLD = cv2.GaussianBlur(np.random.default_rng(0).uniform(60, 160, (1200, 1600)).astype(np.float32), (0, 0), 3)
_STEP = 0.001


def seen(
    time_s: float, place: np.ndarray, turned_rad: np.ndarray, focal_px: float, *, shown: bool = True
) -> Observation:
    """Return what a camera that looks along z, turned about y and x, sees of the disc at a place (2,) = (x/z, y/z)."""
    R = rotation_by(np.array([0.0, turned_rad[0], 0.0])) @ rotation_by(np.array([-turned_rad[1], 0.0, 0.0]))
    world = _WORLD.copy()
    if shown:
        centre = np.array([800, 600]) + place / _STEP
        cv2.circle(world, tuple(int(16 * v) for v in centre), int(16 * RADIUS / _STEP), 250.0, -1, cv2.LINE_AA, 4)
    camera = CameraModel(WIDTH, HEIGHT, focal_px)
    K = np.array([[focal_px, 0, 0.5 * WIDTH], [0, focal_px, 0.5 * HEIGHT], [0, 0, 1.0]])
    to_world = np.array([[1 / _STEP, 0, 800], [0, 1 / _STEP, 600], [0, 0, 1.0]])
    H = K @ R.T @ np.linalg.inv(to_world)
    grey = cv2.warpPerspective(world, H, (WIDTH, HEIGHT), flags=cv2.INTER_AREA)
    image = np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
    T = np.eye(4)
    T[:3, :3] = R
    return Observation(image, time_s, camera, ego=EgoPose(T))


def pixel(observation: Observation, place: np.ndarray) -> np.ndarray:
    ray = observation.ego.T_world_camera[:3, :3].T @ [*place, 1.0]
    return observation.camera.centre_px + observation.camera.focal_px * ray[:2] / ray[2]


@pytest.mark.parametrize("zooms", [False, True])
def test_it_follows_a_disc_whatever_the_camera_does(zooms: bool) -> None:
    tracker = entry("panorama_difference").create(np.random.default_rng(0))
    for k in range(60):
        place = np.array([0.004 * k, 0.02 * np.sin(0.2 * k)])
        turned = place + 0.02 * np.array([np.sin(0.3 * k), np.cos(0.37 * k)])
        observation = seen(k / RATE_HZ, place, turned, 1200.0 * (0.6 ** np.sin(0.15 * k) if zooms else 1.0))
        true_px = pixel(observation, place)
        if k == 0:
            tracker.initialise(observation, box_around(true_px, np.full(2, 2 * RADIUS * 1200.0)))
            continue
        estimate = tracker.update(observation)
        assert estimate.in_view_probability > 0.5, k
        # What lies behind the first box is not known at first.
        assert (
            np.abs(estimate.position_px - true_px).max()
            < (1.0 if k < 20 else 0.5) * RADIUS * observation.camera.focal_px
        ), k


def test_it_says_when_the_target_is_hidden_and_finds_it_again() -> None:
    tracker = entry("panorama_difference").create(np.random.default_rng(0))
    for k in range(50):
        place = np.array([0.005 * k, 0.0])
        observation = seen(k / RATE_HZ, place, place, 800.0, shown=not 20 <= k < 26)
        if k == 0:
            tracker.initialise(observation, box_around(pixel(observation, place), np.full(2, 2 * RADIUS * 800.0)))
            continue
        estimate = tracker.update(observation)
        if 20 <= k < 26:
            assert estimate.in_view_probability < 0.5, k
        elif not 26 <= k < 32:
            assert estimate.in_view_probability > 0.5, k
            assert (
                np.abs(estimate.position_px - pixel(observation, place)).max()
                < (1.0 if k < 20 else 0.5) * RADIUS * 800.0
            ), k


def test_the_controller_turns_to_the_target_and_zooms_out_where_it_went() -> None:
    lead = LeadPtz(LeadPtzParameters(lead_s=0.0, gain_per_s=2.0, grace_s=0.3, search_per_s=0.4))
    nothing = Estimate(np.full(2, np.nan))
    at_rest = seen(0.0, np.zeros(2), np.zeros(2), 1000.0)
    assert lead.command(at_rest, nothing).pan_rad_s == 0.0
    for k in range(1, 11):
        observation = seen(k / RATE_HZ, np.zeros(2), np.zeros(2), 1000.0)
        command = lead.command(observation, Estimate(np.array([80.0 + 2.0 * k, 60.0]), in_view_probability=1.0))
    # 20 pixels to the right at a focal length of 1000 are 0.02 rad; a pan to the right is negative.
    assert command.pan_rad_s == pytest.approx(-2.0 * 0.02, rel=0.01)
    assert command.tilt_rad_s == pytest.approx(0.0, abs=1e-9)
    lost = [lead.command(seen(1.0 + k / RATE_HZ, np.zeros(2), np.zeros(2), 1000.0), nothing) for k in range(1, 9)]
    # It goes on to where the target went, and zooms out after a while.
    assert lost[-1].pan_rad_s < lost[0].pan_rad_s < command.pan_rad_s
    assert lost[0].zoom_per_s == 0.0
    assert lost[-1].zoom_per_s == -0.4
