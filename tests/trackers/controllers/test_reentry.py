"""The commands of ``reentry`` for a belief, in a gust, after a loss and without estimates."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from sim.optics import PinholeCamera, intersect_plane, look_down_pose, project
from trackers.belief.kernel import BELIEF
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.reentry import ReentryController, ReentryParameters, nearest_seen
from trackers.types import CameraModel, EgoPose, Estimate, Observation

CAMERA = PinholeCamera.from_field_of_view(640, 480, np.deg2rad(50))
HEIGHT_M = 41.0
HALF_AHEAD_M, HALF_RIGHT_M = HEIGHT_M * 240 / CAMERA.focal_px, HEIGHT_M * 320 / CAMERA.focal_px
MIRRORED = [name for name in BELIEF.names if "right" in name]


def _beliefs(count=1, **values):
    beliefs = np.zeros(count, BELIEF)
    given = {
        "frames": 50.0, "height_m": HEIGHT_M, "half_ahead_m": HALF_AHEAD_M, "half_right_m": HALF_RIGHT_M,
        "known": 1.0, "spread_m": 0.5, "in_view_probability": 1.0, "densest_share": 1.0,
    } | values  # fmt: skip
    for name, value in given.items():
        beliefs[name] = value
    return beliefs


def _steered(beliefs, **changes):
    parameters = dataclasses.replace(ReentryParameters(), **changes)
    out = np.full((len(beliefs), 4), np.nan)
    kernel, count = ReentryController.KERNEL, len(beliefs)
    kernel.steer(beliefs, kernel.record(parameters), np.zeros(count, kernel.memory), np.zeros(count), out)
    return out


def _random_beliefs(rng, count=400):
    beliefs = _beliefs(count)
    for name in ("ahead_m", "right_m", "axis_ahead_m", "axis_right_m", "densest_ahead_m", "densest_right_m"):
        beliefs[name] = rng.normal(0, 30, count)
    for name in BELIEF.names:
        if name.endswith("_mps"):
            beliefs[name] = rng.normal(0, 20, count)
    beliefs["spread_m"] = rng.choice([0.0, 0.5, 15.0], count)
    beliefs["seconds_since_seen"] = rng.choice([0.0, 5.0], count)
    return beliefs


def test_the_mirrored_belief_gives_the_mirrored_command():
    beliefs = _random_beliefs(np.random.default_rng(0))
    beliefs["spread_m"] = np.maximum(beliefs["spread_m"], 0.1)
    mirrored = beliefs.copy()
    for name in MIRRORED:
        if not name.startswith("half"):
            mirrored[name] *= -1
    np.testing.assert_allclose(_steered(mirrored), _steered(beliefs) * [1, -1, 1, 1], atol=1e-9)


def test_commands_are_finite_and_within_limits():
    out = _steered(_random_beliefs(np.random.default_rng(1)))
    assert np.isfinite(out).all()
    assert np.hypot(out[:, 0], out[:, 1]).max() <= 25.0 + 1e-9
    assert np.abs(out[:, 2]).max() <= 5.0
    assert (out[:, 3] == 0.0).all()


def test_many_beliefs_are_steered_as_each_alone():
    beliefs = _random_beliefs(np.random.default_rng(2), 20)
    alone = np.concatenate([_steered(beliefs[k : k + 1]) for k in range(20)])
    assert (_steered(beliefs) == alone).all()


def test_nothing_known_and_nothing_ever_seen_is_answered():
    assert np.isfinite(_steered(np.zeros(1, BELIEF))).all()


def test_a_target_that_drives_on_under_the_camera_is_flown_along_with():
    beliefs = _beliefs(velocity_ahead_mps=9.0, velocity_right_mps=-2.0, own_ahead_mps=9.0, own_right_mps=-2.0)
    np.testing.assert_allclose(_steered(beliefs)[0, :2], [9.0, -2.0], atol=1e-9)


def test_a_small_offset_from_its_place_is_let_be():
    parameters = ReentryParameters()
    still = parameters.rest * HALF_AHEAD_M
    command = _steered(_beliefs(ahead_m=0.9 * still + parameters.lean * 3.0, axis_ahead_m=3.0))
    np.testing.assert_allclose(command, 0.0, atol=1e-9)


@pytest.mark.parametrize("direction_rad", np.linspace(0, 2 * np.pi, 9)[:-1])
def test_a_gust_is_answered_the_other_way(direction_rad):
    axis_m = 35.0 * np.array([np.cos(direction_rad), np.sin(direction_rad)])
    out = _steered(_beliefs(axis_ahead_m=axis_m[0], axis_right_m=axis_m[1]))[0]
    assert out[:2] @ axis_m < -5.0 * 35.0


def test_a_gust_is_answered_before_the_target_is_out():
    calm = _steered(_beliefs(axis_ahead_m=8.0))
    rising = _steered(_beliefs(axis_ahead_m=8.0, axis_ahead_mps=40.0))
    dying = _steered(_beliefs(axis_ahead_m=8.0, axis_ahead_mps=-40.0))
    assert rising[0, 0] < calm[0, 0] - 5.0
    assert dying[0, 0] > calm[0, 0] + 5.0


@pytest.mark.parametrize("tilt", [0.4, 0.5, 0.6])
def test_where_it_comes_to_rest_the_target_is_in_view_in_the_gust_and_after_it(tilt):
    ahead_m = 0.0
    for _ in range(400):
        command = _steered(_beliefs(axis_ahead_m=tilt * HEIGHT_M, ahead_m=ahead_m))[0]
        assert command[1] == 0.0
        ahead_m -= 0.05 * command[0]
    assert abs(command[0]) < 0.05
    for pitch in (np.arctan(tilt), 0.0):
        T = look_down_pose(np.array([0.0, 0.0, HEIGHT_M]), 0.0, pitch, 0.0)
        pixel, _ = project(CAMERA, T, np.array([ahead_m, 0.0, 0.0]))
        assert ((pixel > 0) & (pixel < [640, 480])).all()


def test_nearest_seen_is_the_clipped_pixel_on_the_ground():
    rng = np.random.default_rng(3)
    for pitch, roll in rng.uniform(-0.6, 0.6, (20, 2)):
        T = look_down_pose(np.array([0.0, 0.0, 1.0]), 0.0, pitch, roll)
        place = rng.uniform(-0.3, 0.3, 2)
        pixel, _ = project(CAMERA, T, np.array([*place, 0.0]))
        axis, expected = (
            intersect_plane(CAMERA, T, seen, 0.0) for seen in ([320.0, 240.0], np.clip(pixel, 0, [640, 480]))
        )
        got = nearest_seen(
            place[0], -place[1], axis[0], -axis[1], 240 / CAMERA.focal_px, 320 / CAMERA.focal_px
        )  # fmt: skip
        np.testing.assert_allclose(got, [expected[0], -expected[1]], atol=1e-9)


def test_a_lost_target_leads_to_the_densest_window_and_up():
    beliefs = _beliefs(
        spread_m=20.0, ahead_m=-10.0, densest_ahead_m=25.0, densest_right_m=-15.0, seconds_since_seen=4.0
    )
    out = _steered(beliefs)[0]
    assert out[0] > 5.0
    assert out[1] < -3.0
    assert out[2] > 1.0


def test_a_known_target_is_followed_low():
    assert _steered(_beliefs(height_m=70.0))[0, 2] == -ReentryParameters().sink_mps
    assert _steered(_beliefs(height_m=41.0))[0, 2] == 0.0


def test_without_posterior_it_looks_where_it_has_not_looked():
    onwards = _beliefs(known=0.0, spread_m=0.0, seconds_since_seen=6.0, velocity_x_mps=8.0)
    back = onwards.copy()
    back["searched"][0, [7, 0, 1]] = 1.0
    assert _steered(onwards)[0, 0] > 5.0
    assert abs(_steered(back)[0, 1]) > 5.0


def _observation(k):
    T = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.3, 0.02 * k, -0.01 * k)
    camera = CameraModel(640, 480, CAMERA.focal_px)
    return Observation(np.zeros((2, 2, 3), np.uint8), k / 15, camera, ego=EgoPose(T))


def test_it_is_ours_deterministic_and_its_commands_are_finite():
    assert controller_entry("reentry", "helicopter").role == "ours"
    runs = []
    for _ in range(2):
        controller = controller_entry("reentry", "helicopter").create()
        commands = []
        for k in range(40):
            place = np.full(2, np.nan) if k in (0, 20) else np.array([320.0 + 40 * k, 240.0 - 30 * k])
            commands.append(dataclasses.astuple(controller.command(_observation(k), Estimate(place))))
        runs.append(np.array(commands))
    assert np.isfinite(runs[0]).all()
    assert (runs[0] == runs[1]).all()
