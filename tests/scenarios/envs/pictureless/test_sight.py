"""Truth and sightings without pictures equal those of the rendered env."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios.envs.pictureless.episode_state import EPISODE_STATE
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.envs.pictureless.sight_kernel import count_out, look, write_sighting_ahead, write_sighting_down
from scenarios.envs.pictureless.vector_env import terms_of, weights_of
from scenarios.envs.reward import TERMS, Reward, Rewarder
from scenarios.road_town.flight import HELICOPTER
from scenarios.stereo_follow.robot import ROBOT
from sim.optics import look_down_pose, project
from sim.pose import pose_on_ground
from trackers.belief.kernel import SIGHTING
from trackers.belief.sighting import sighting_of
from trackers.types import CameraModel, EgoPose, Estimate, Observation

CAMERA = CameraModel(640, 480, 500.0)
SIZE_M = np.array([4.6, 1.9, 1.5])


@njit
def look_one(states: Any, size_m: Any, camera: Any, covered: float) -> None:
    look(states[0], size_m, camera, covered)
    count_out(states[0])


@njit
def write_one(states: Any, camera: Any, sighting: Any, down: bool) -> None:
    if down:
        write_sighting_down(states[0], camera, sighting[0])
    else:
        write_sighting_ahead(states[0], camera, sighting[0])


def above(rng: np.random.Generator) -> np.ndarray:
    place_m = np.array([*rng.normal(0, 25, 2), rng.uniform(40, 90)])
    return look_down_pose(place_m, rng.uniform(-3, 3), *rng.normal(0, 0.25, 2))


def states_at(T_world_camera: np.ndarray, heading_rad: float) -> np.ndarray:
    states = np.zeros(1, EPISODE_STATE)
    states["R"], states["camera_m"] = T_world_camera[:3, :3], T_world_camera[:3, 3]
    states["R_measured"], states["camera_measured_m"] = states["R"], states["camera_m"]
    states["target_rad"] = heading_rad
    return states


def truth_of(T_world_camera: np.ndarray, heading_rad: float) -> Any:
    """Return the rendered env's truth of a box at the origin."""
    pose = pose_on_ground(0.0, 0.0, heading_rad)
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)]) * SIZE_M
    pixels = project(CAMERA, T_world_camera, corners @ pose[:3, :3].T)[0]
    centre = project(CAMERA, T_world_camera, np.array([[0.0, 0.0, 0.5 * SIZE_M[2]]]))[0]
    box = np.array([[*pixels.min(axis=0), *pixels.max(axis=0)]])
    return SimpleNamespace(position_px=centre, box_xyxy=box)


@pytest.mark.heavy
def test_truth_and_reward_are_those_of_the_rendered_env() -> None:
    rng = np.random.default_rng(7)
    reward = Reward(1.0, 0.7, 0.5, 0.3, 2.0, loss_after_s=0.2)
    rewarder, limits = Rewarder(reward, 15.0), np.array([25.0, 25.0, 5.0, 1.0])
    states, terms, seen = np.zeros(1, EPISODE_STATE), np.zeros((1, len(TERMS))), 0
    for _ in range(300):
        heading_rad, pose = rng.uniform(-3, 3), above(rng)
        frames_out = states["frames_out"].copy()
        states = states_at(pose, heading_rad)
        states["frames_out"], states["obeyed"] = frames_out, limits * rng.uniform(-1, 1, 4)
        look_one(states, SIZE_M, camera_numbers(CAMERA), 0.0)
        truth = truth_of(pose, heading_rad)
        np.testing.assert_allclose(states["target_px"][0], truth.position_px[0], atol=1e-6)
        frame: Any = SimpleNamespace(judged=(truth, CAMERA))
        effort = float(np.linalg.norm(states["obeyed"][0] / limits) / 2.0)
        expected = rewarder.terms(frame, 0, effort)
        terms_of(states, weights_of(reward), 3, 640.0, limits, terms)
        np.testing.assert_allclose(terms[0], list(expected.values()), atol=1e-9)
        seen += int(states["in_view"][0])
        box = truth.box_xyxy[0]
        shown = np.minimum(box[2:], [640, 480]) - np.maximum(box[:2], 0)
        share = np.prod(np.maximum(shown, 0)) / np.prod(box[2:] - box[:2])
        assert states["visible"][0] == pytest.approx(share, abs=1e-9)
    assert 50 < seen < 250


@pytest.mark.heavy
@pytest.mark.parametrize("carrier", [HELICOPTER, ROBOT], ids=lambda carrier: carrier.name)
def test_sightings_are_those_of_the_rendered_env(carrier: Any) -> None:
    rng = np.random.default_rng(8)
    down = carrier.looks == "down"
    for _ in range(50):
        pose = above(rng)
        if not down:
            pose = look_down_pose(np.array([*rng.normal(0, 5, 2), 1.2]), rng.uniform(-3, 3), 0.5 * np.pi, 0.0)
        states, sighting = states_at(pose, 0.0), np.ones(1, SIGHTING)
        place_px = rng.uniform(-200, 800, 2)
        states["known"], states["estimate_px"], states["depth_m"] = 1.0, place_px, 3.3
        states["probability"], states["length_share"] = 0.8, 0.1
        states["densest_share"] = 1.0
        write_one(states, camera_numbers(CAMERA), sighting, down)
        estimate = Estimate(
            place_px,
            box_xyxy=np.array([0.0, 0.0, 64.0, 20.0]),
            in_view_probability=0.8,
            depth_m=None if down else 3.3,
        )
        model = CameraModel(640, 480, 500.0)
        observation = Observation(np.zeros((480, 640, 3), np.uint8), 0.0, model, ego=EgoPose(pose))
        expected = sighting_of(carrier.looks, observation, estimate)
        for name in SIGHTING.names or ():
            np.testing.assert_allclose(sighting[name], expected[name], atol=1e-9, err_msg=name)
        states["known"] = 0.0
        write_one(states, camera_numbers(CAMERA), sighting, down)
        expected = sighting_of(carrier.looks, observation, Estimate(np.full(2, np.nan), in_view_probability=0.3))
        for name in SIGHTING.names or ():
            np.testing.assert_allclose(sighting[name], expected[name], atol=1e-9, err_msg=name)
