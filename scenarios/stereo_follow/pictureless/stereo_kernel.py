"""Pictureless ``stereo-follow``: beginnings and steps of many drives at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.command_link import send
from scenarios.envs.pictureless.error_kernel import start_tracker, track
from scenarios.envs.pictureless.error_model import WRONG
from scenarios.envs.pictureless.life import NOBODY
from scenarios.envs.pictureless.poses import in_camera
from scenarios.envs.pictureless.sight_kernel import look, tell_ahead
from scenarios.envs.pictureless.starts import frame_before
from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M
from scenarios.stereo_follow.odometry import SCALE_ERROR, TURN_SCALE_ERROR
from scenarios.stereo_follow.pictureless.drive_kernel import covered_share, drive, is_walled, look_ahead

_NEAREST_M, _FARTHEST_M = 0.5, 8.0
"""People are taken for the target at these distances."""


@njit(cache=True)
def begin_drives(
    lives: Any,
    which: NDArray[np.int64],
    episodes: NDArray[np.int64],
    at_losses: bool,
    bank: Any,
    errors: Any,
    camera: NDArray[np.float64],
    interval_s: float,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Begin episodes (K,) in the lives ``which`` (K,): on frame 0, or on the way a little before the target is lost by
    who drives by hand.
    """
    target_m, target_rad, size_m, others_m, _, openings_m, path_m, yaw_rad, onsets = bank
    for n in range(len(which)):
        life, episode = lives[which[n]], episodes[n]
        frame = frame_before(onsets[episode], rng) if at_losses else 0
        life.episode, life.frame, life.steps, life.frames_out = episode, frame, 0, 0
        for axis in range(2):
            life.place_m[axis] = path_m[episode, frame, axis]
            life.shake_rad[axis] = 0.0
        life.place_m[2] = 0.0
        life.yaw_rad = yaw_rad[episode, frame]
        life.speed_mps = life.yaw_rate_rad_s = 0.0
        for axis in range(3):
            life.odometry[axis] = 0.0
        life.odometry_scales[0] = 1.0 + SCALE_ERROR * rng.standard_normal()
        life.odometry_scales[1] = 1.0 + TURN_SCALE_ERROR * rng.standard_normal()
        if at_losses:
            east_m = path_m[episode, frame + 1, 0] - path_m[episode, frame, 0]
            north_m = path_m[episode, frame + 1, 1] - path_m[episode, frame, 1]
            life.speed_mps = np.hypot(east_m, north_m) / interval_s
            life.yaw_rate_rad_s = (yaw_rad[episode, frame + 1] - yaw_rad[episode, frame]) / interval_s
        for axis in range(4):
            life.command[axis] = life.obeyed[axis] = 0.0
        life.command[0] = life.obeyed[0] = life.speed_mps
        life.command[3] = life.obeyed[3] = life.yaw_rate_rad_s
        start_tracker(life, rng)
        _see(life, target_m, target_rad, size_m, others_m, openings_m, camera, rng)
        track(life, errors[0], size_m[episode], _sight_rad(life), camera, rng)
        tell_ahead(life, camera, sightings[which[n]])


@njit(cache=True)
def drive_on(
    lives: Any,
    wanted: NDArray[np.float64],
    limits: NDArray[np.float64],
    steps: NDArray[np.float64],
    waiting: NDArray[np.float64],
    link_noise: float,
    bank: Any,
    errors: Any,
    camera: NDArray[np.float64],
    interval_s: float,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Move all lives on by one frame, by commands (B, 4), and write what the tracker says of it."""
    target_m, target_rad, size_m, others_m, free_m, openings_m = bank[:6]
    for k in range(len(lives)):
        life = lives[k]
        send(life, wanted[k], limits, steps, waiting[k], link_noise, rng)
        drive(life, free_m[life.episode], interval_s, rng)
        life.frame += 1
        life.steps += 1
        _see(life, target_m, target_rad, size_m, others_m, openings_m, camera, rng)
        track(life, errors[0], size_m[life.episode], _sight_rad(life), camera, rng)
        tell_ahead(life, camera, sightings[k])


@njit(cache=True)
def _see(
    life: Any,
    target_m: Any,
    target_rad: Any,
    size_m: Any,
    others_m: Any,
    openings_m: Any,
    camera: Any,
    rng: np.random.Generator,
) -> None:
    episode, frame = life.episode, life.frame
    life.target_m[0], life.target_m[1] = target_m[episode, frame, 0], target_m[episode, frame, 1]
    life.target_rad = target_rad[episode, frame]
    look_ahead(life, rng)
    _notice_others(life, others_m[episode, frame], openings_m[episode], camera)
    look(life, size_m[episode], camera, covered_share(life, others_m[episode, frame], openings_m[episode]))


@njit(cache=True)
def _sight_rad(life: Any) -> float:
    return np.arctan2(life.target_m[1] - life.camera_m[1], life.target_m[0] - life.camera_m[0])


@njit(cache=True)
def _notice_others(life: Any, others_m: NDArray[np.float64], openings_m: Any, camera: Any) -> None:
    """Note who is taken for the target, if somebody is or comes to be: of those in sight the nearest."""
    if life.mode != WRONG:
        life.other, nearest_m = NOBODY, _FARTHEST_M
        for n in range(len(others_m)):
            away_m = np.hypot(others_m[n, 0] - life.place_m[0], others_m[n, 1] - life.place_m[1])
            if away_m < nearest_m and _is_in_sight(life, others_m[n], openings_m, camera):
                life.other, nearest_m = n, away_m
    elif life.other >= 0 and not _is_in_sight(life, others_m[life.other], openings_m, camera):
        life.other = NOBODY
    if life.other >= 0:
        life.other_offset_m[0] = others_m[life.other, 0] - life.target_m[0]
        life.other_offset_m[1] = others_m[life.other, 1] - life.target_m[1]


@njit(cache=True)
def _is_in_sight(life: Any, place_m: NDArray[np.float64], openings_m: Any, camera: Any) -> bool:
    """Return whether a place (2,) is in the picture, not behind a wall and not too far."""
    right_m, _, ahead_m = in_camera(life.R, life.camera_m, place_m[0], place_m[1], CAMERA_HEIGHT_M)
    if not _NEAREST_M < ahead_m < _FARTHEST_M or abs(right_m) * camera[0] > ahead_m * camera[1]:
        return False
    return not is_walled(life.place_m[0], life.place_m[1], place_m[0], place_m[1], openings_m)
