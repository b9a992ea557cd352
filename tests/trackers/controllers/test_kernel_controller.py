"""Centring and searching controllers command what plain formulas say, on random pictures, poses and answers."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from sim.optics import look_down_pose
from trackers.controllers.catalogue import controller_entry, controllers
from trackers.types import CameraCommand, CameraModel, EgoPose, Estimate, Observation, SteeredCamera

RATE_HZ, FRAMES = 15.0, 80
CAMERA = CameraModel(320, 240, 300.0)
PARTS = ("forward_mps", "right_mps", "climb_mps", "yaw_rate_rad_s")


def pid(
    history: dict[str, Any], time_s: float, error: Any, integral_gain: float, derivative: float, limit: float
) -> Any:
    """Return the integral's and the derivative's part of a command; ``history`` is empty at the start."""
    since_s, before = time_s - history.get("time_s", np.inf), history.get("error", error)
    history.update(time_s=time_s, error=error)
    history.setdefault("sum", 0.0)
    if since_s <= 0.0:
        return integral_gain * history["sum"]
    history["sum"] = np.clip(history["sum"] + since_s * error, -limit, limit)
    return integral_gain * history["sum"] + derivative * (error - before) / since_s


def ground_m(T: Any, tangents: Any) -> Any:
    """Return where a ray meets the ground, ahead and right of the point below the camera; NaN if it does not."""
    ray = T[:3, :3] @ [*tangents, 1.0]
    ahead = -T[:2, 1] / np.linalg.norm(T[:2, 1])
    on_m = ray[:2] * T[2, 3] / -ray[2] if ray[2] < 0.0 else np.full(2, np.nan)
    return np.array([on_m @ ahead, on_m @ [ahead[1], -ahead[0]]])


def sequence(carrier: str, seed: int) -> Iterator[tuple[Observation, Estimate]]:
    """Yield pictures of a swaying camera that moves, and answers that stop and start, some above the horizon."""
    rng = np.random.default_rng(seed)
    mount_rad, place_m, is_known = 0.5 * np.pi if carrier == "robot" else 0.8 * (seed % 2), rng.normal(0, 300, 2), True
    for frame in range(FRAMES):
        place_m = place_m + rng.normal(0, 0.5, 2)
        sway = (0.02 if carrier == "robot" else 0.3) * rng.normal(size=2) * (frame > 0)
        height_m = 1.2 if carrier == "robot" else rng.uniform(40, 70)
        T = look_down_pose(np.array([*place_m, height_m]), 0.02 * frame + seed, mount_rad + sway[0], sway[1])
        is_known ^= rng.random() < 0.07
        position_px = rng.normal([160, 120], [100, 80]) - [0.0, 700.0 * (rng.random() < 0.1)]
        estimate = Estimate(
            position_px if is_known else np.full(2, np.nan),
            in_view_probability=float(rng.random() * is_known),
            covariance_px=rng.choice([4.0, 4e4]) * np.eye(2),
            depth_m=float(rng.uniform(0.5, 5.0)) if carrier == "robot" and rng.random() < 0.8 else None,
        )
        pose = EgoPose(T) if carrier == "robot" or seed % 4 else None
        yield Observation(np.zeros((2, 2, 3), np.uint8), frame / RATE_HZ, CAMERA, ego=pose), estimate


def centring(p: Any, history: dict[str, Any], observation: Observation, estimate: Estimate) -> list[float]:
    tangents = (estimate.position_px - [160.0, 120.0]) / CAMERA.focal_px
    if observation.ego is None:
        target_m, axis_m, mount_m = 60.0 * np.array([-tangents[1], tangents[0]]), np.zeros(2), 0.0
    else:
        T = observation.ego.T_world_camera
        target_m, axis_m = ground_m(T, tangents), ground_m(T, (0.0, 0.0))
        slope = axis_m[0] / T[2, 3]
        history.setdefault("slope", slope if slope > 120.0 / CAMERA.focal_px else 0.0)
        mount_m = history["slope"] * T[2, 3]
    off_m = target_m - [p.levelled * mount_m, 0.0]
    off_m = off_m if p.levelled == 1.0 else off_m - (1.0 - p.levelled) * axis_m
    if not np.isfinite(off_m).all():
        history.pop("time_s", None)
        return [0.0, 0.0, p.climb_mps, 0.0]
    limit = p.fastest_mps / max(p.integral_per_s2, 1e-9)
    velocity = p.gain_per_s * off_m + pid(history, observation.time_s, off_m, p.integral_per_s2, p.derivative, limit)
    velocity *= min(1.0, p.fastest_mps / max(np.linalg.norm(velocity), 1e-9))
    turn = -p.turn_per_s * np.arctan2(target_m[1], max(target_m[0], 0.5 * mount_m)) if mount_m else 0.0
    return [*velocity, p.climb_mps, turn]


def turning(p: Any, history: dict[str, Any], observation: Observation, estimate: Estimate) -> list[float]:
    if np.isnan(estimate.position_px).any():
        history.pop("time_s", None)
        return [0.0] * 4
    left_rad = -np.arctan((estimate.position_px[0] - 160.0) / CAMERA.focal_px)
    gains = p.turn_integral_per_s2, p.turn_derivative
    terms = pid(history, observation.time_s, left_rad, *gains, 0.5)
    away_m = (estimate.depth_m or 3.0) / np.cos(left_rad) - p.distance_m
    return [p.speed_gain_per_s * away_m * np.cos(left_rad), 0.0, 0.0, p.turn_gain_per_s * left_rad + terms]


@pytest.mark.parametrize(("carrier", "formula"), [("helicopter", centring), ("robot", turning)])
@pytest.mark.parametrize("name", ["centre", "centre_as_written"])
@pytest.mark.parametrize("seed", range(4))
def test_centring_follows_its_formula(carrier: str, formula: Any, name: str, seed: int) -> None:
    entry, history = controller_entry(name, carrier), {}
    controller = entry.create()
    commands = []
    for observation, estimate in sequence(carrier, seed):
        command = controller.command(observation, estimate)
        commands.append([getattr(command, part) for part in PARTS])
        expected = formula(entry.parameters(), history, observation, estimate)
        np.testing.assert_allclose(commands[-1], expected, rtol=1e-9, atol=1e-9)
    assert (np.ptp(commands, axis=0)[[0, 3] if carrier == "robot" or seed in (1, 3) else [0, 1]] > 1.0).all()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_helicopter_that_searches_flies_a_square_about_the_place_last_seen(seed: int) -> None:
    changes = {"patience_s": 0.43, "lost_spread_m": 5.0, "search_mps": 20.0}
    entry, history = controller_entry("search", "helicopter"), {}
    p, controller = entry.parameters(**changes), entry.create(**changes)
    unseen_s = searching_s = 0.0
    seen_m, searched = np.zeros(2), 0
    for frame, (observation, estimate) in enumerate(sequence("helicopter", seed)):
        command = controller.command(observation, estimate)
        expected = centring(p, history, observation, estimate)
        T, is_known = observation.ego.T_world_camera, bool(np.isfinite(estimate.position_px).all())
        ahead = -T[:2, 1] / np.linalg.norm(T[:2, 1])
        # No time has passed before the first picture; a belief takes it to be a second.
        interval_s = 1.0 / RATE_HZ if frame else 1.0
        unseen_s += interval_s
        if is_known and (estimate.in_view_probability >= 0.5 or frame == 0):
            ray = T[:3, :3] @ [*(estimate.position_px - [160.0, 120.0]) / CAMERA.focal_px, 1.0]
            seen_m = T[:2, 3] + ray[:2] * T[2, 3] / max(-ray[2], T[2, 3] / 500.0)
            unseen_s = unseen_s if estimate.in_view_probability < 0.5 else 0.0
        spread_m = T[2, 3] / CAMERA.focal_px * np.sqrt(estimate.covariance_px[0, 0])
        if (is_known and spread_m <= p.lost_spread_m) or unseen_s <= p.patience_s:
            searching_s = 0.0
        else:
            searching_s, searched = searching_s + interval_s, searched + 1
            leg_m = max(p.apart * 240.0 / CAMERA.focal_px * T[2, 3], 1.0)
            corners_m = leg_m * np.cumsum([0, 1, 1j, -2, -2j, 3, 3j, -4, -4j])
            ways_m = leg_m * np.cumsum([0, 1, 1, 2, 2, 3, 3, 4, 4])
            place = np.interp(p.search_mps * searching_s, ways_m, corners_m)
            off_m = seen_m - T[:2, 3] + [place.real, place.imag] - history.get("slope", 0.0) * T[2, 3] * ahead
            velocity = p.gain_per_s * off_m
            velocity *= min(1.0, p.fastest_mps / np.linalg.norm(velocity))
            expected = [velocity @ ahead, velocity @ [ahead[1], -ahead[0]], p.climb_mps, 0.0]
        np.testing.assert_allclose([getattr(command, part) for part in PARTS], expected, rtol=1e-9, atol=1e-9)
    assert searched > 3


@pytest.mark.parametrize("seed", range(4))
def test_a_robot_that_searches_turns_for_a_second_and_then_drives_to_the_place_last_seen(seed: int) -> None:
    entry, history = controller_entry("search", "robot"), {}
    p, controller = entry.parameters(), entry.create()
    lost_at_s, aside, seen_m, drove = None, 0.0, np.full(2, np.nan), 0
    for frame, (observation, estimate) in enumerate(sequence("robot", seed)):
        command = controller.command(observation, estimate)
        T, time_s = observation.ego.T_world_camera, observation.time_s
        if np.isfinite(estimate.position_px).all():
            lost_at_s = None
            tangents = (estimate.position_px - [160.0, 120.0]) / CAMERA.focal_px
            aside = tangents[0]
            if frame == 0 or estimate.in_view_probability >= 0.5:
                seen_m = T[:2, 3] + (T[:3, :3] @ [*tangents, 1.0])[:2] * (estimate.depth_m or 3.0)
            expected = turning(p, history, observation, estimate)
        else:
            lost_at_s = time_s if lost_at_s is None else lost_at_s
            expected = [0.0, 0.0, 0.0, -p.search_rad_s if aside > 0.0 else p.search_rad_s]
            way_m = seen_m - T[:2, 3]
            if time_s - lost_at_s >= p.turn_s and np.linalg.norm(way_m) >= p.reached_m:
                turn_rad = np.angle(complex(*way_m) / complex(*T[:2, 2]))
                speed_mps = min(p.speed_gain_per_s * np.linalg.norm(way_m), 1.0) * max(np.cos(turn_rad), 0.0)
                expected, drove = [speed_mps, 0.0, 0.0, p.turn_gain_per_s * turn_rad], drove + 1
        np.testing.assert_allclose([getattr(command, part) for part in PARTS], expected, rtol=1e-9, atol=1e-9)
    assert drove or seed


HEADS = ("tank-head", "harbour-head")
ZOOMED = CameraModel(160, 120, 900.0)


def beside_a_head(seed: int) -> Iterator[tuple[Observation, Estimate]]:
    """Yield pictures of a camera at rest and answers that stop and start, beside the camera of a head that turns."""
    rng, is_known = np.random.default_rng(seed), True
    above = look_down_pose(np.array([3.0, 2.0, 20.0]), 0.4, 0.2, 0.0)
    for frame in range(FRAMES):
        head = look_down_pose(np.array([-12.0, 0.0, 15.0]), 0.02 * frame - 1.6, rng.uniform(0.4, 1.2), 0.0)
        steered = SteeredCamera(dataclasses.replace(ZOOMED, focal_px=rng.uniform(600, 2000)), EgoPose(head))
        is_known ^= rng.random() < 0.1 and frame > 0
        position_px = rng.normal([160, 120], [80, 60]) if is_known else np.full(2, np.nan)
        estimate = Estimate(position_px, covariance_px=rng.uniform(0.1, 90.0) * np.eye(2))
        picture = np.zeros((2, 2, 3), np.uint8)
        yield Observation(picture, frame / RATE_HZ, CAMERA, ego=EgoPose(above), steered=steered), estimate


def on_level_m(T: Any, tangents: Any) -> Any:
    """Return where a ray meets the ground."""
    ray = T[:3, :3] @ [*tangents, 1.0]
    return T[:2, 3] + ray[:2] * T[2, 3] / -ray[2]


@pytest.mark.parametrize("carrier", HEADS)
@pytest.mark.parametrize("seed", range(3))
def test_a_head_turns_to_where_the_estimate_lies_on_the_ground(carrier: str, seed: int) -> None:
    entry = controller_entry("centre", carrier)
    controller, gain, turned = entry.create(), entry.parameters().gain_per_s, 0
    for observation, estimate in beside_a_head(seed):
        command = controller.command(observation, estimate)
        if np.isnan(estimate.position_px).any():
            assert command == CameraCommand()
            continue
        place_m = on_level_m(observation.ego.T_world_camera, (estimate.position_px - [160.0, 120.0]) / CAMERA.focal_px)
        T = observation.steered.ego.T_world_camera
        x, y, z = T[:3, :3].T @ ([*place_m, 0.0] - T[:3, 3])
        if z > 0.0:
            np.testing.assert_allclose(command.pan_rad_s, -gain * np.arctan2(x, z), rtol=1e-9)
            np.testing.assert_allclose(command.tilt_rad_s, -gain * np.arctan2(y, z), rtol=1e-9)
            turned += 1
        assert command.zoom_per_s == 0.0
    assert turned > 20


@pytest.mark.parametrize("carrier", HEADS)
@pytest.mark.parametrize("seed", range(3))
def test_a_head_leads_its_target_and_zooms_by_the_spread(carrier: str, seed: int) -> None:
    entry = controller_entry("lead", carrier)
    p, controller = entry.parameters(), entry.create()
    place_m, velocity_mps, was_known, waited_s = np.zeros(2), np.zeros(2), False, 0.0
    for frame, (observation, estimate) in enumerate(beside_a_head(seed)):
        command, T = controller.command(observation, estimate), observation.ego.T_world_camera
        is_known = bool(np.isfinite(estimate.position_px).all())
        waited_s += 1.0 / RATE_HZ
        if is_known:
            # An alpha-beta filter, see ``trackers.belief.kernel``; a position in the picture says that it is in view.
            now_m = on_level_m(T, (estimate.position_px - [160.0, 120.0]) / CAMERA.focal_px)
            step_m = now_m - place_m - velocity_mps / RATE_HZ
            if was_known and frame and np.linalg.norm(step_m) * RATE_HZ < 30.0:
                velocity_mps = velocity_mps + 0.12 * RATE_HZ * step_m
            place_m = now_m
            seen = (np.abs(estimate.position_px - [160.0, 120.0]) <= [160.0, 120.0]).all()
            waited_s = 0.0 if seen else waited_s
        was_known = is_known
        ahead_s = p.lead_s
        if not is_known:
            ahead_s += p.patience_s * (1.0 - np.exp(-waited_s / p.patience_s))
        head = observation.steered.ego.T_world_camera
        forward = head[:2, 2] + head[2, 2] * head[:2, 1]
        forward /= np.linalg.norm(forward)
        goal = complex(*(place_m + ahead_s * velocity_mps - head[:2, 3])) / complex(*forward)
        axis_m = np.linalg.norm(on_level_m(head, (0.0, 0.0)) - head[:2, 3])
        tilt_rad = np.arctan2(head[2, 3], axis_m) - np.arctan2(head[2, 3], abs(goal))
        np.testing.assert_allclose(command.pan_rad_s, p.gain_per_s * np.angle(goal), rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(command.tilt_rad_s, p.gain_per_s * tilt_rad, rtol=1e-7, atol=1e-9)
        zoom = -1.0
        if is_known:
            reach_m = np.hypot(np.linalg.norm(now_m - T[:2, 3]), T[2, 3])
            spread_m = reach_m / CAMERA.focal_px * np.sqrt(estimate.covariance_px[0, 0])
            half_m = np.hypot(axis_m, head[2, 3]) * 80.0 / observation.steered.camera.focal_px
            zoom = np.log(half_m / (p.margin * (spread_m + np.linalg.norm(velocity_mps) * p.lead_s)))
        np.testing.assert_allclose(command.zoom_per_s, p.zoom_gain_per_s * zoom, rtol=1e-5)


def test_a_head_that_was_never_told_of_its_target_stays() -> None:
    controller = controller_entry("lead", "tank-head").create()
    for observation, _ in beside_a_head(0):
        assert controller.command(observation, Estimate(np.full(2, np.nan))) == CameraCommand()


def test_a_head_without_a_measured_pose_turns_by_the_picture() -> None:
    controller = controller_entry("centre", "tank-head").create(gain_per_s=2.0)
    observation = Observation(np.zeros((240, 320, 3), np.uint8), 0.0, CAMERA)
    command = controller.command(observation, Estimate(np.array([220.0, 120.0])))
    np.testing.assert_allclose(command.pan_rad_s, -2.0 * np.arctan(60.0 / CAMERA.focal_px), rtol=1e-9)


@pytest.mark.parametrize("carrier", ["helicopter", "robot", *HEADS])
def test_all_that_are_shipped_for_a_carrier_without_pictures_have_kernels(carrier: str) -> None:
    ours = [entry for entry in controllers(carrier).values() if entry.controller.__module__.startswith("trackers.")]
    assert len(ours) >= 4
    # The input of a policy's network is not a belief alone.
    for entry in (each for each in ours if each.role != "policy"):
        assert entry.kernel is not None, entry.name
        names = {field.name for field in dataclasses.fields(entry.parameters_class)}
        assert set(entry.kernel.parameters.names or ()) == names
