"""Controllers of many envs command what their classes do, env by env."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scenarios.envs.pictureless.episode_state import EPISODE_STATE, KernelWorld, measured_camera
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.envs.pictureless.vector_env import SeparateControllers, vector_controller
from scenarios.fish_tank.scenario import HEAD
from scenarios.road_town.flight import HELICOPTER
from scenarios.stereo_follow.robot import ROBOT
from sim.optics import look_down_pose
from trackers.belief.kernel import BELIEF, update_beliefs
from trackers.belief.sighting import sighting_of
from trackers.controllers.catalogue import controller_entry
from trackers.types import CameraModel, Carrier, SteeredCamera

CAMERA = CameraModel(64, 48, 50.0)
WORLD = KernelWorld(SimpleNamespace(camera=camera_numbers(CAMERA), interval_s=1.0 / 15.0), None)
ENVS, FRAMES, AGAIN_AT = 3, 70, 40


class BesideOverview(KernelWorld):
    """A head, beside a camera at rest above."""

    def cameras(self, state: Any) -> tuple[SteeredCamera, SteeredCamera | None]:
        above = look_down_pose(np.array([0.0, 0.0, 20.0]), 0.3, 0.1, 0.0)
        return measured_camera(self.camera, above[:3, :3], above[:3, 3]), super().cameras(state)[0]


HEADS = BesideOverview(SimpleNamespace(camera=camera_numbers(CAMERA), interval_s=1.0 / 15.0), None)


def set_state(state: Any, down: bool, is_known: bool, rng: np.random.Generator) -> None:
    """Set measured pose and answer; posteriors are narrow or wide, since one class gets them as Gaussians."""
    height_m, pitch_rad = (rng.uniform(40, 70), 0.0) if down else (1.2, 0.5 * np.pi)
    sway_rad = rng.normal(0, 0.2 if down else 0.02, 2)
    place_m = np.array([*rng.normal(0, 3, 2), height_m])
    T = look_down_pose(place_m, rng.uniform(-0.3, 0.3), pitch_rad + sway_rad[0], sway_rad[1])
    state["R_measured"], state["camera_measured_m"] = T[:3, :3], T[:3, 3]
    state["known"], state["estimate_px"] = is_known, rng.uniform(-20, 80, 2)
    state["depth_m"] = height_m if down else rng.uniform(0.5, 5)
    state["probability"], state["length_share"], state["densest_share"] = rng.random(), 0.1, 1.0
    state["spread_m"] = rng.choice([0.1, 300.0])


@pytest.mark.parametrize(
    ("carrier", "name"),
    [*product([HELICOPTER, ROBOT], ["hold", "centre", "search"]), *product([HEAD], ["hold", "centre", "lead"])],
    ids=lambda each: getattr(each, "name", each),
)
def test_commands_are_those_of_the_class_in_each_env(carrier: Carrier, name: str) -> None:
    rng, down = np.random.default_rng(5), carrier.looks != "ahead"
    world = HEADS if carrier.looks == "around" else WORLD
    entry, settings = controller_entry(name, carrier.name), SimpleNamespace(controller=name, controller_values={})
    together = vector_controller(settings, carrier, world, ENVS)
    alone = SeparateControllers(entry.create, carrier, world, ENVS)
    assert not isinstance(together, SeparateControllers)
    states, beliefs = np.zeros(ENVS, EPISODE_STATE), np.zeros(ENVS, BELIEF)
    commands, expected = np.zeros((2, FRAMES, ENVS, 4))
    is_known = np.ones(ENVS, bool)
    for frame in range(FRAMES):
        is_known ^= rng.random(ENVS) < 0.05
        begun = np.flatnonzero([frame == 0, frame in (0, AGAIN_AT), frame == 0])
        for each in (together, alone):
            each.begin(begun)
        states["steps"] += 1
        states["steps"][begun], beliefs[begun], is_known[begun] = 0, np.zeros(1, BELIEF), True
        for k in range(ENVS):
            set_state(states[k], down, bool(is_known[k]), rng)
        states["probability"][begun] = 1.0
        given = [(alone.observation(state), alone.estimate(state)) for state in states]
        update_beliefs(beliefs, np.concatenate([sighting_of(carrier.looks, *each) for each in given]), WORLD.interval_s)
        together.command(states, beliefs, commands[frame])
        alone.command(states, beliefs, expected[frame])
    np.testing.assert_allclose(commands, expected, rtol=1e-9, atol=1e-9)
    assert (name == "hold") == (np.ptp(commands) == 0.0)
