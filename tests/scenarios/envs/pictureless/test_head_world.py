"""Heads without pictures turn, see and are told as those of the rendered env."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios import catalog
from scenarios.command_link import Link, LinkLimits, link_limits
from scenarios.envs.follow_env import followed_episode
from scenarios.envs.pictureless.bank import EpisodeBank
from scenarios.envs.pictureless.error_kernel import ERRORS
from scenarios.envs.pictureless.head_bank import HeadPictureless
from scenarios.envs.pictureless.head_world import HEAD_STATE, look_around, turn_head, write_sighting_around
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.envs.settings import FollowSettings
from scenarios.fish_tank.scenario import MOUNT as TANK
from scenarios.harbour.scenario import MOUNT as HARBOUR
from scenarios.pan_tilt_zoom import Head
from scenarios.visibility import is_in_view
from sim.optics import look_down_pose
from sim.rng import episode_seed
from trackers.belief.kernel import SIGHTING
from trackers.belief.sighting import sighting_of
from trackers.types import CameraCommand, CameraModel, EgoPose, Estimate, Observation, SteeredCamera

RATE_HZ = 15.0


@njit
def turn_one(states: Any, lens: Any, limits: Any, axes: Any, place_m: Any, link: LinkLimits) -> None:
    turn_head(states[0], lens, limits[0], limits[1], link, 1.0 / RATE_HZ)
    look_around(states[0], axes, place_m)


@njit
def write_one(states: Any, surveyed: Any, watched: Any, measured_m: Any, sighting: Any) -> None:
    write_sighting_around(states[0], surveyed, watched, measured_m, sighting[0])


@pytest.mark.heavy
@pytest.mark.parametrize("mount", [TANK, HARBOUR], ids=lambda mount: mount.carrier.name)
def test_heads_turn_and_zoom_alike(mount: Any) -> None:
    rng, head, carrier = np.random.default_rng(3), Head(mount, RATE_HZ), mount.carrier
    link = link_limits(carrier, RATE_HZ, Link(), carrier.commands)
    states, least = np.zeros(1, HEAD_STATE), np.array([-mount.widest_pan_rad, mount.tilt_rad[0], mount.zoom[0]])
    limits = np.array([least, [mount.widest_pan_rad, mount.tilt_rad[1], mount.zoom[1]]])
    states["head"] = head.pan_rad, head.tilt_rad, head.zoom
    wanted, at_limit = np.zeros(3), 0
    for frame in range(300):
        # Long pushes to one side reach the limits.
        wanted = rng.normal(0.0, 2.0, 3) if frame % 15 == 0 else wanted
        command = CameraCommand(pan_rad_s=wanted[0], tilt_rad_s=wanted[1], zoom_per_s=wanted[2])
        head.obey(command)
        states["obeyed"] = [getattr(command, name) for name in carrier.commands]
        turn_one(states, camera_numbers(mount.lens), limits, head.axes, np.array(mount.place_m), link)
        np.testing.assert_allclose(states["head"][0], [head.pan_rad, head.tilt_rad, head.zoom], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(states["R"][0], head.T_world_camera[:3, :3], atol=1e-12)
        np.testing.assert_array_equal(states["camera_m"][0], mount.place_m)
        np.testing.assert_allclose(states["lens"][0], camera_numbers(head.camera), rtol=1e-12)
        at_limit += np.isin(states["head"][0], limits).any()
    assert 10 < at_limit < 290


@pytest.mark.heavy
def test_sightings_are_those_of_the_rendered_env() -> None:
    rng, overview = np.random.default_rng(8), CameraModel(384, 288, 770.0)
    names = [name for name in SIGHTING.names or () if name != "spread_m"]
    for _ in range(60):
        head = Head(HARBOUR, 5.0)
        head.pan_rad, head.tilt_rad, head.zoom = rng.uniform(-0.8, 0.8), rng.uniform(-0.9, 0.1), rng.uniform(0.5, 3.0)
        above = look_down_pose(
            rng.normal([-100.0, 0.0, 20.0], 0.1), rng.normal(-1.57, 0.1), rng.uniform(0.8, 1.6), 0.01
        )
        own = head.T_world_camera
        states, sighting = np.zeros(1, HEAD_STATE), np.ones(1, SIGHTING)
        states["R"], states["lens"] = own[:3, :3], camera_numbers(head.camera)
        place_px = rng.uniform(-50, 400, 2)
        states["known"], states["estimate_px"], states["probability"] = 1.0, place_px, 0.8
        states["length_share"], states["densest_share"] = 40.0 / 384.0, 1.0
        estimate = Estimate(place_px, box_xyxy=np.array([0.0, 0.0, 40.0, 9.0]), in_view_probability=0.8)
        observation = Observation(
            np.zeros((288, 384, 3), np.uint8),
            0.0,
            overview,
            ego=EgoPose(above),
            steered=SteeredCamera(head.camera, EgoPose(own)),
        )
        for answer in (estimate, Estimate(np.full(2, np.nan), in_view_probability=0.3)):
            write_one(states, above[:3], camera_numbers(overview), own[:3, 3], sighting)
            expected = sighting_of("around", observation, answer)
            for name in names:
                np.testing.assert_allclose(sighting[name], expected[name], rtol=1e-9, atol=1e-9, err_msg=name)
            states["known"] = 0.0


SMALL = {"frame_count": 25, "width_px": 160, "height_px": 120}


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "more"), [("fish-tank-v1", {}), ("harbour-v1", {"background": 0})])
def test_plans_and_views_are_those_of_the_rendered_episode(name: str, more: dict[str, Any]) -> None:
    scenario = catalog.scenario(name)
    settings = FollowSettings(name, "hold", preset="quick", changes=SMALL | more)
    preset, seed = settings.configuration({}), 7
    planner = HeadPictureless()
    planner.scenario = name
    arrays = planner.arrays(preset, episode_seed(seed, name, 0))
    assert all(np.isfinite(values).all() for values in arrays.values())
    bank = EpisodeBank(name, preset, np.array([seed]), {key: values[None] for key, values in arrays.items()})
    rng, carrier = np.random.default_rng(5), scenario.carrier
    loop = followed_episode(settings, seed)
    link = link_limits(carrier, preset.rate_hz, Link(), carrier.commands)
    world = planner.world(preset, bank.arrays, link, np.zeros(1, ERRORS))
    states, sighting, waiting = np.zeros(1, world.state_dtype), np.zeros(1, SIGHTING), np.zeros((1, 0, 4))
    command, seen = None, 0
    for frame in range(preset.frame_count):
        shown = loop.step(command)
        if command is None:
            world.begin(states, np.zeros(1, int), np.zeros(1, int), False, sighting, rng)
        else:
            wanted = np.array([[getattr(command, axis) for axis in carrier.commands]])
            world.move(states, wanted, waiting, sighting, rng)
        target = shown.truth.index_of(scenario.target)
        np.testing.assert_array_equal(arrays["target_m"][frame], shown.truth.T_world_object[target, :3, 3])
        assert arrays["hidden"][frame] == 1.0 - shown.truth.visible_fraction[target]
        truth, camera = shown.judged
        np.testing.assert_allclose(states["target_px"][0], truth.position_px[target], atol=0.3)
        assert states["in_view"][0] == is_in_view(truth, target, camera)
        seen += int(states["in_view"][0])
        watched, steered = world.cameras(states[0])
        assert watched.camera.focal_px == pytest.approx(shown.camera.focal_px)
        np.testing.assert_array_equal(watched.ego.T_world_camera, shown.observation.ego.T_world_camera)
        assert steered.camera.focal_px == pytest.approx(camera.focal_px)
        measured = shown.observation.steered.ego.T_world_camera
        np.testing.assert_allclose(steered.ego.T_world_camera, measured, atol=1e-12)
        # Towards the target, roughly.
        right_rad, down_rad = np.arctan((truth.position_px[target] - camera.centre_px) / camera.focal_px)
        pan_rad_s, tilt_rad_s = 0.5 * preset.rate_hz * rng.uniform(0.0, 1.5, 2) * (-right_rad, -down_rad)
        command = CameraCommand(pan_rad_s=pan_rad_s, tilt_rad_s=tilt_rad_s, zoom_per_s=rng.uniform(-0.3, 0.3))
    assert seen > 0
    loop.episode.close()
