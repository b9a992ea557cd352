"""The tracker against a drawn sphere of noise on which a disc moves, seen by a camera that turns and zooms."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from sim.pose import rotation_by
from trackers.baselines.panorama_difference import Panorama, PanoramaDifference
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
    world = _WORLD.copy()
    if shown:
        centre = np.array([800, 600]) + place / _STEP
        cv2.circle(world, tuple(int(16 * v) for v in centre), int(16 * RADIUS / _STEP), 250.0, -1, cv2.LINE_AA, 4)
    return looking(world, time_s, turned_rad, focal_px)


def looking(world: np.ndarray, time_s: float, turned_rad: np.ndarray, focal_px: float) -> Observation:
    """Return what the camera sees of a picture of the world."""
    R = rotation_by(np.array([0.0, turned_rad[0], 0.0])) @ rotation_by(np.array([-turned_rad[1], 0.0, 0.0]))
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


def discs(time_s: float, *discs: tuple[np.ndarray, float, tuple[int, int]], turned_rad: np.ndarray) -> Observation:
    """Return a picture with ellipses: place (2,), brightness and half axes in thousandths each."""
    world = _WORLD.copy()
    for place, level, half in discs:
        centre = tuple(round(float(v)) for v in np.array([800, 600]) + place / _STEP)
        cv2.ellipse(world, centre, half, 0.0, 0.0, 360.0, level, -1, cv2.LINE_AA)
    return looking(world, time_s, turned_rad, 800.0)


ROUND, TARGET, AT_REST = (12, 12), 250.0, np.zeros(2)


def started(first: Observation, place: np.ndarray) -> PanoramaDifference:
    tracker = entry("panorama_difference").create(np.random.default_rng(0))
    tracker.initialise(first, box_around(pixel(first, place), np.full(2, 2 * RADIUS * 800.0)))
    return tracker


def test_what_the_target_leaves_behind_is_not_taken_for_it() -> None:
    # It goes from its first place at once and is then hidden: what lay behind it was never seen before.
    tracker = started(discs(0.0, (AT_REST, TARGET, ROUND), turned_rad=AT_REST), AT_REST)
    for k in range(1, 4):
        tracker.update(discs(k / RATE_HZ, (np.array([0.006 * k, 0.0]), TARGET, ROUND), turned_rad=AT_REST))
    for k in range(4, 14):
        assert tracker.update(discs(k / RATE_HZ, turned_rad=AT_REST)).in_view_probability < 0.5, k


@pytest.mark.parametrize("way", [0.004, 0.006])
def test_it_keeps_to_the_target_beside_another_one_that_touches_it(way: float) -> None:
    # Both stay in touch for 2 s: a part that wears away would be gone by then.
    target, other = np.array([0.0, 0.0]), np.array([0.0, 0.06])
    tracker = started(discs(0.0, (target, TARGET, ROUND), (other, TARGET, ROUND), turned_rad=AT_REST), target)
    for k in range(1, 40):
        along = np.array([way * k, 0.0])
        between = 0.02 if 10 <= k < 30 else 0.06 - 0.004 * k if k < 10 else 0.02 + 0.004 * (k - 29)
        both = ((along, TARGET, ROUND), (along + np.array([0.0, between]), TARGET, ROUND))
        observation = discs(k / RATE_HZ, *both, turned_rad=along)
        estimate = tracker.update(observation)
        assert estimate.in_view_probability > 0.5, k
        assert np.abs(estimate.position_px - pixel(observation, along)).max() < RADIUS * 800.0, k


@pytest.mark.parametrize(
    "else_there",
    [(150.0, ROUND), (TARGET, (90, 2))],
    ids=["paler, as a shadow is", "longer and thinner"],
)
def test_something_unlike_the_target_is_not_taken_for_it(else_there: tuple[float, tuple[int, int]]) -> None:
    tracker = started(discs(0.0, (AT_REST, TARGET, ROUND), turned_rad=AT_REST), AT_REST)
    for k in range(1, 8):
        tracker.update(discs(k / RATE_HZ, (np.array([0.004 * k, 0.0]), TARGET, ROUND), turned_rad=AT_REST))
    for k in range(8, 16):
        beside = np.array([0.03, 0.022])
        estimate = tracker.update(discs(k / RATE_HZ, (beside, *else_there), turned_rad=AT_REST))
        assert estimate.in_view_probability < 0.5, k


def test_a_panorama_shows_nothing_that_lies_behind_its_plane() -> None:
    camera = CameraModel(WIDTH, HEIGHT, 100.0)
    panorama = Panorama(camera, np.eye(3), 0.002)
    grey = np.full((HEIGHT, WIDTH), 100.0, np.float32)
    # It looks 80° to the right, so that its right border looks backwards, then all of it does.
    for turned_rad, is_seen in ((np.deg2rad(80.0), True), (np.deg2rad(150.0), False)):
        panorama.show(camera, rotation_by(np.array([0.0, turned_rad, 0.0])))
        corners = panorama.places(np.array([[0.0, 0.0], [WIDTH, 0.0], [WIDTH, HEIGHT], [0.0, HEIGHT]], float))
        assert np.isfinite(corners).all()
        assert np.isfinite(panorama.laid(grey)).any() == is_seen
        left = panorama.places(np.array([[0.0, 0.5 * HEIGHT]]))[0, 0]
        if is_seen:
            assert panorama.window[1].start == pytest.approx(left, abs=2.0 + 0.5 * WIDTH)
            assert panorama.window[1].stop == panorama.background.base.shape[1]
        # The first picture's middle is behind the camera or beside it: its pixel is not in the picture.
        x, y = panorama.pixels(np.array([[1536.0, 768.0]]))[0]
        assert not (0.0 <= x < WIDTH and 0.0 <= y < HEIGHT)
