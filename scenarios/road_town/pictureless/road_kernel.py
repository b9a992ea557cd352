"""Pictureless ``road-town``: beginnings and steps of many flights at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.command_link import send
from scenarios.envs.pictureless.error_kernel import start_tracker, track
from scenarios.envs.pictureless.sight_kernel import look, tell_down
from scenarios.envs.pictureless.starts import frame_before
from scenarios.road_town.flight import ALTITUDE_RANGE_M
from scenarios.road_town.pictureless.flight_kernel import fly, look_down

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
_LOWEST_M = ALTITUDE_RANGE_M[0]
_OFF_COURSE_M = 3.0


@njit(cache=True)
def begin_flights(
    lives: Any,
    which: NDArray[np.int64],
    episodes: NDArray[np.int64],
    at_gusts: bool,
    bank: Any,
    noise: Any,
    errors: Any,
    camera: NDArray[np.float64],
    interval_s: float,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Begin episodes (K,) in the lives ``which`` (K,): on frame 0, or in mid-flight a little before a gust."""
    target_m, target_rad, size_m, attitude_rad, start_m, path_m, yaw_rad, onsets = bank
    scratch = np.zeros(3)
    for n in range(len(which)):
        life, episode = lives[which[n]], episodes[n]
        frame = frame_before(onsets[episode], rng) if at_gusts else 0
        life.episode, life.frame, life.steps, life.frames_out = episode, frame, 0, 0
        for axis in range(3):
            life.velocity_mps[axis] = 0.0
            life.place_m[axis] = start_m[episode, axis]
            life.position_bias_m[axis] = noise[0].position_bias_m * rng.standard_normal()
            life.attitude_bias_rad[axis] = noise[0].attitude_bias_rad * rng.standard_normal()
        life.yaw_rad, life.yaw_rate_rad_s = yaw_rad[episode, 0], 0.0
        if at_gusts:
            for axis in range(2):
                step_m = path_m[episode, frame + 1, axis] - path_m[episode, frame, axis]
                life.velocity_mps[axis] = step_m / interval_s
                life.place_m[axis] = path_m[episode, frame, axis] + _OFF_COURSE_M * rng.standard_normal()
            life.place_m[2] = _LOWEST_M + rng.random() * (start_m[episode, 2] - _LOWEST_M)
        _hold_speed(life)
        start_tracker(life, rng)
        _see(life, target_m, target_rad, size_m, attitude_rad, noise[0], camera, rng, scratch)
        track(life, errors[0], size_m[episode], life.target_rad, camera, rng)
        tell_down(life, camera, sightings[which[n]])


@njit(cache=True)
def fly_on(
    lives: Any,
    wanted: NDArray[np.float64],
    limits: NDArray[np.float64],
    steps: NDArray[np.float64],
    waiting: NDArray[np.float64],
    link_noise: float,
    bank: Any,
    noise: Any,
    errors: Any,
    camera: NDArray[np.float64],
    interval_s: float,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Move all lives on by one frame, by commands (B, 4), and write what the tracker says of it."""
    target_m, target_rad, size_m, attitude_rad = bank[0], bank[1], bank[2], bank[3]
    scratch = np.zeros(3)
    for k in range(len(lives)):
        life = lives[k]
        send(life, wanted[k], limits, steps, waiting[k], link_noise, rng)
        fly(life, interval_s)
        life.frame += 1
        life.steps += 1
        _see(life, target_m, target_rad, size_m, attitude_rad, noise[0], camera, rng, scratch)
        track(life, errors[0], size_m[life.episode], life.target_rad, camera, rng)
        tell_down(life, camera, sightings[k])


@njit(cache=True)
def _see(
    life: Any,
    target_m: Any,
    target_rad: Any,
    size_m: Any,
    attitude_rad: Any,
    noise: Any,
    camera: Any,
    rng: np.random.Generator,
    scratch: Any,
) -> None:
    episode, frame = life.episode, life.frame
    life.target_m[0], life.target_m[1] = target_m[episode, frame, 0], target_m[episode, frame, 1]
    life.target_rad = target_rad[episode, frame]
    look_down(life, attitude_rad[episode, frame], noise.position_noise_m, noise.attitude_noise_rad, rng, scratch)
    look(life, size_m[episode], camera, 0.0)


@njit(cache=True)
def _hold_speed(life: Any) -> None:
    """Let the latest command be the one that the carrier's motion answers."""
    c, s = np.cos(life.yaw_rad), np.sin(life.yaw_rad)
    life.command[0] = c * life.velocity_mps[0] + s * life.velocity_mps[1]
    life.command[1] = s * life.velocity_mps[0] - c * life.velocity_mps[1]
    life.command[2] = life.command[3] = 0.0
    for axis in range(4):
        life.obeyed[axis] = life.command[axis]
