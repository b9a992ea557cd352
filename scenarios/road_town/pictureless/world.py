"""Helicopters over towns, without pictures."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits, send
from scenarios.envs.pictureless.episode_state import KernelWorld, begin_state, state_dtype
from scenarios.envs.pictureless.error_kernel import start_tracker, track
from scenarios.envs.pictureless.poses import camera_numbers, pitch_forward, turn_down, turned
from scenarios.envs.pictureless.sight_kernel import count_out, look, place_target, write_sighting_down
from scenarios.road_town.flight import (
    MAXIMUM_CLIMB_MPS,
    MAXIMUM_SPEED_MPS,
    MAXIMUM_YAW_RATE_RAD_S,
    RESPONSE_TIME_S,
)
from scenarios.road_town.presets import ALTITUDE_RANGE_M, RoadTown
from trackers.kernels.records import record_kernel
from trackers.types import CameraModel

_LOWEST_M, _HIGHEST_M = ALTITUDE_RANGE_M
FLIGHT_STATE = state_dtype(
    ("velocity_mps", "f8", (3,)), ("position_bias_m", "f8", (3,)), ("attitude_bias_rad", "f8", (3,))
)
"""State of a flight: with its velocity and the constant errors of its instruments."""


@record_kernel()
def fly(state: Any, turned_rad: float, interval_s: float) -> None:
    """Obey ``state.obeyed`` for one frame: a first-order response of all velocities.

    Args:
        turned_rad: yaw of the air, by which a pitched camera's heading deviates; 0 for one that looks straight down.
    """
    wanted = state.obeyed
    c, s = np.cos(state.yaw_rad + turned_rad), np.sin(state.yaw_rad + turned_rad)
    east, north = c * wanted[0] + s * wanted[1], s * wanted[0] - c * wanted[1]
    slower = min(1.0, MAXIMUM_SPEED_MPS / max(np.sqrt(east * east + north * north), 1e-9))
    climb = min(max(wanted[2], -MAXIMUM_CLIMB_MPS), MAXIMUM_CLIMB_MPS)
    response = 1.0 - np.exp(-interval_s / RESPONSE_TIME_S)
    state.velocity_mps[0] += response * (slower * east - state.velocity_mps[0])
    state.velocity_mps[1] += response * (slower * north - state.velocity_mps[1])
    state.velocity_mps[2] += response * (climb - state.velocity_mps[2])
    yaw_rate = min(max(wanted[3], -MAXIMUM_YAW_RATE_RAD_S), MAXIMUM_YAW_RATE_RAD_S)
    state.yaw_rate_rad_s += response * (yaw_rate - state.yaw_rate_rad_s)
    for axis in range(3):
        state.place_m[axis] += state.velocity_mps[axis] * interval_s
    state.place_m[2] = min(max(state.place_m[2], _LOWEST_M), _HIGHEST_M)
    state.yaw_rad += state.yaw_rate_rad_s * interval_s


@record_kernel()
def look_down(
    state: Any,
    attitude_rad: NDArray[np.float64],
    mount_rad: float,
    position_noise_m: float,
    attitude_noise_rad: float,
    rng: np.random.Generator,
    scratch: NDArray[np.float64],
) -> None:
    """Write the camera's pose, true and as measured.

    Args:
        attitude_rad: (3,) roll, pitch, yaw due to air and gusts on this frame.
        mount_rad: by which the camera is pitched forward.
    """
    turn_down(state.R, state.yaw_rad + attitude_rad[2], attitude_rad[1], attitude_rad[0])
    pitch_forward(state.R, mount_rad)
    for axis in range(3):
        state.camera_m[axis] = state.place_m[axis]
        noise_m = position_noise_m * rng.standard_normal()
        state.camera_measured_m[axis] = state.place_m[axis] + state.position_bias_m[axis] + noise_m
        scratch[axis] = state.attitude_bias_rad[axis] + attitude_noise_rad * rng.standard_normal()
    turned(state.R, scratch, state.R_measured)


ROAD_NOISE = np.dtype(
    [
        ("position_bias_m", "f8"),
        ("position_noise_m", "f8"),
        ("attitude_bias_rad", "f8"),
        ("attitude_noise_rad", "f8"),
    ],
    align=True,
)
"""Errors of the instruments."""
_OFF_COURSE_M = 3.0


class Flights(NamedTuple):
    """Planned flights as arrays, see ``RoadPictureless.arrays``, and the constants of their simulation.

    Attributes:
        noise: (1,) of dtype ``ROAD_NOISE``. errors: (1,) of dtype ``ERRORS``. camera, interval_s: see ``World``.
    """

    target_m: NDArray[np.float64]
    target_rad: NDArray[np.float64]
    size_m: NDArray[np.float64]
    attitude_rad: NDArray[np.float64]
    mount_rad: NDArray[np.float64]
    start_m: NDArray[np.float64]
    path_m: NDArray[np.float64]
    yaw_rad: NDArray[np.float64]
    onsets: NDArray[np.float64]
    noise: NDArray[np.void]
    errors: NDArray[np.void]
    camera: NDArray[np.float64]
    interval_s: float


@record_kernel()
def begin_flights(
    states: Any,
    which: NDArray[np.int64],
    episodes: NDArray[np.int64],
    at_gusts: bool,
    flights: Any,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Begin ``episodes`` (K,) in the rows ``which`` (K,) of ``states``: on frame 0, or shortly before a gust."""
    start_m, path_m, noise = flights.start_m, flights.path_m, flights.noise[0]
    scratch = np.zeros(3)
    for n in range(len(which)):
        state, episode = states[which[n]], episodes[n]
        frame = begin_state(state, episode, flights.onsets[episode], at_gusts, rng)
        for axis in range(3):
            state.velocity_mps[axis] = 0.0
            state.place_m[axis] = start_m[episode, axis]
            state.position_bias_m[axis] = noise.position_bias_m * rng.standard_normal()
            state.attitude_bias_rad[axis] = noise.attitude_bias_rad * rng.standard_normal()
        state.yaw_rad, state.yaw_rate_rad_s = flights.yaw_rad[episode, 0], 0.0
        if at_gusts:
            for axis in range(2):
                step_m = path_m[episode, frame + 1, axis] - path_m[episode, frame, axis]
                state.velocity_mps[axis] = step_m / flights.interval_s
                state.place_m[axis] = path_m[episode, frame, axis] + _OFF_COURSE_M * rng.standard_normal()
            state.place_m[2] = _LOWEST_M + rng.random() * (start_m[episode, 2] - _LOWEST_M)
        _hold_speed(state)
        start_tracker(state, rng)
        _observe(state, flights, sightings[which[n]], rng, scratch)


@record_kernel()
def fly_on(
    states: Any, wanted: Any, waiting: Any, link: LinkLimits, flights: Any, sightings: Any, rng: np.random.Generator
) -> None:
    """Advance all states by one frame under the commands (B, 4), and write their sightings."""
    scratch = np.zeros(3)
    for k in range(len(states)):
        state = states[k]
        send(state, wanted[k], link, waiting[k], rng)
        pitched = flights.mount_rad[state.episode, 0] > 0.0
        turned_rad = flights.attitude_rad[state.episode, state.frame, 2] if pitched else 0.0
        fly(state, turned_rad, flights.interval_s)
        state.frame += 1
        state.steps += 1
        _observe(state, flights, sightings[k], rng, scratch)


@record_kernel(inline="always")
def _observe(state: Any, flights: Any, sighting: Any, rng: np.random.Generator, scratch: Any) -> None:
    """Write the truth of the current frame, the tracker's answer, and the sighting."""
    episode, noise, camera = state.episode, flights.noise[0], flights.camera
    place_target(state, flights.target_m, flights.target_rad)
    attitude_rad = flights.attitude_rad[episode, state.frame]
    mount_rad = flights.mount_rad[episode, 0]
    look_down(state, attitude_rad, mount_rad, noise.position_noise_m, noise.attitude_noise_rad, rng, scratch)
    look(state, flights.size_m[episode], camera, 0.0)
    count_out(state)
    track(state, flights.errors[0], flights.size_m[episode], state.target_rad, camera, rng)
    write_sighting_down(state, camera, sighting)


@record_kernel()
def _hold_speed(state: Any) -> None:
    """Set the latest command to the current velocity."""
    c, s = np.cos(state.yaw_rad), np.sin(state.yaw_rad)
    state.command[0] = c * state.velocity_mps[0] + s * state.velocity_mps[1]
    state.command[1] = s * state.velocity_mps[0] - c * state.velocity_mps[1]
    state.command[2] = state.command[3] = 0.0
    for axis in range(4):
        state.obeyed[axis] = state.command[axis]


class RoadWorld(KernelWorld):
    """See ``KernelWorld``."""

    state_dtype = FLIGHT_STATE
    begin_kernel, move_kernel = staticmethod(begin_flights), staticmethod(fly_on)

    def __init__(
        self, preset: RoadTown, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        camera = CameraModel.from_field_of_view(
            preset.width_px, preset.height_px, float(np.deg2rad(preset.field_of_view_deg))
        )
        ego = preset.ego
        assert ego is not None
        degrees = np.deg2rad([ego.attitude_bias_deg, ego.attitude_noise_deg])
        noise = np.array([(ego.position_bias_m, ego.position_noise_m, degrees[0], degrees[1])], ROAD_NOISE)
        numbers, interval_s = camera_numbers(camera), 1.0 / preset.rate_hz
        super().__init__(Flights(**arrays, noise=noise, errors=errors, camera=numbers, interval_s=interval_s), link)
