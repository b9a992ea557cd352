"""Rough air has its configured statistics, gusts tilt in their directions, and the helicopter obeys commands."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.road_town.flight import (
    AirState,
    Helicopter,
    Pulse,
    draw_air,
    gust_attitude_rad,
)
from scenarios.road_town.pilot import IN, OUT, PARTIAL, frame_out_spans, picture_states
from scenarios.road_town.presets import PRESETS
from sim.optics import intersect_plane, look_down_pose, project
from sim.rng import generator
from trackers.types import CameraCommand, CameraModel

PRESET = PRESETS["standard"]
CAMERA = CameraModel.from_field_of_view(640, 480, np.deg2rad(50.0))


def _calm(frames: int, yaw_rad: float = 0.0) -> AirState:
    return AirState(60.0, np.zeros((frames, 3)), np.zeros((frames, 2)), yaw_rad)


def test_attitude_noise_has_the_stated_deviation_and_no_bias():
    drawn = np.concatenate([draw_air(PRESET, 0.0, generator(k, "air")).attitude_rad for k in range(60)])
    wanted = np.deg2rad(PRESET.attitude_noise_deg) * np.array([1.0, 1.0, 1.5])
    np.testing.assert_allclose(drawn.std(axis=0), wanted, rtol=0.1)
    np.testing.assert_allclose(drawn.mean(axis=0), 0.0, atol=0.15 * wanted.max())


@pytest.mark.parametrize("offset_m", [(20.0, 0.0), (-20.0, 0.0), (0.0, 25.0), (0.0, -25.0)])
def test_a_gust_moves_the_aim_by_its_offset(offset_m):
    helicopter = Helicopter(PRESET, _calm(60), [Pulse(10, 5, 20, 5, offset_m, True)], np.zeros(2))
    poses = [helicopter.pose(frame) for frame in range(60)]
    aim = intersect_plane(CAMERA, poses[25], CAMERA.centre_px, 0.0)
    np.testing.assert_allclose(aim, offset_m, atol=1e-6)
    np.testing.assert_allclose(intersect_plane(CAMERA, poses[0], CAMERA.centre_px, 0.0), 0.0, atol=1e-6)
    np.testing.assert_allclose(intersect_plane(CAMERA, poses[-1], CAMERA.centre_px, 0.0), 0.0, atol=1e-6)


def test_drift_does_not_tilt():
    assert not gust_attitude_rad([Pulse(0, 5, 5, 5, (30.0, 0.0), False)], 60.0, 20).any()


def test_helicopter_reaches_the_commanded_velocity_in_its_own_frame():
    helicopter = Helicopter(PRESET, _calm(100, np.pi / 2), [], np.zeros(2))
    for _ in range(90):
        before = helicopter.pose(0)[:3, 3].copy()
        helicopter.fly(CameraCommand(forward_mps=5.0, right_mps=2.0, climb_mps=0.5))
    velocity = (helicopter.pose(0)[:3, 3] - before) * PRESET.rate_hz
    np.testing.assert_allclose(velocity, [2.0, 5.0, 0.5], atol=0.05)


def test_helicopter_at_rest_stays_put_and_refuses_nan():
    helicopter = Helicopter(PRESET, _calm(10), [], np.array([3.0, 4.0]))
    first = helicopter.pose(0)
    helicopter.fly(CameraCommand())
    np.testing.assert_array_equal(helicopter.pose(1), first)
    with pytest.raises(ValueError, match="command: expected finite"):
        helicopter.fly(CameraCommand(forward_mps=float("nan")))


def test_states_agree_with_projected_corners():
    corners = np.array([[x, y, z] for x in (-2.0, 2.0) for y in (-1.0, 1.0) for z in (0.0, 1.5)])
    places = np.column_stack([np.linspace(-60, 60, 121), np.zeros(121)])
    poses = np.tile(look_down_pose(np.array([0.0, 0.0, 60.0]), 0.0, 0.0, 0.0), (121, 1, 1))
    moved = corners[None] + np.concatenate([places, np.zeros((121, 1))], axis=1)[:, None]
    states = picture_states(CAMERA, poses, moved)
    for k in range(121):
        pixels, _ = project(CAMERA, poses[k], moved[k])
        inside = ((pixels >= 0) & (pixels <= [640, 480])).all(axis=1)
        if states[k] == IN:
            assert inside.all()
        elif states[k] == OUT:
            assert not inside.any()
        else:
            assert states[k] == PARTIAL
            assert not inside.all()
    assert {IN, PARTIAL, OUT} == set(states.tolist())


def test_spans_are_those_of_a_plain_loop():
    rng = np.random.default_rng(1)
    states = rng.integers(0, 3, 200)
    spans, start = [], None
    for k, state in enumerate([*states.tolist(), IN]):
        if state == OUT and start is None:
            start = k
        if state != OUT and start is not None:
            spans.append((start, k))
            start = None
    assert frame_out_spans(states) == spans
