"""Robots in buildings, without pictures."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits, send
from scenarios.envs.pictureless.episode_state import NO_OTHER, KernelWorld, begin_state, state_dtype
from scenarios.envs.pictureless.error_kernel import start_tracker, track
from scenarios.envs.pictureless.error_model import WRONG
from scenarios.envs.pictureless.poses import camera_numbers, in_camera, turn_down
from scenarios.envs.pictureless.sight_kernel import count_out, look, place_target, write_sighting_ahead
from scenarios.stereo_follow.camera import CAMERA_HEIGHT_M, camera
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.rig import SCALE_ERROR, TURN_SCALE_ERROR, add_up
from scenarios.stereo_follow.robot import driven
from scenarios.stereo_follow.scenario import NOD_KEPT, NOD_RAD
from scenarios.stereo_follow.sight import covered_share, is_walled
from trackers.kernels.records import record_kernel

DRIVE_STATE = state_dtype(
    ("speed_mps", "f8"), ("shake_rad", "f8", (2,)), ("odometry", "f8", (3,)), ("odometry_scales", "f8", (2,))
)
"""State of a drive: with its speed, the camera's shaking, and the odometry."""
_HALF_TURN_RAD = 0.5 * np.pi


@record_kernel()
def drive(state: Any, free_m: NDArray[np.float64], interval_s: float, rng: np.random.Generator) -> None:
    """Obey ``state.obeyed`` for one frame, and advance the odometry.

    Args:
        free_m: (P, 4) rectangles x0, y0, x1, y1 where the robot can be.
    """
    x_m, y_m, yaw_rad = state.place_m[0], state.place_m[1], state.yaw_rad
    state.place_m[0], state.place_m[1], state.yaw_rad, state.speed_mps, state.yaw_rate_rad_s = driven(
        state.place_m,
        yaw_rad,
        state.speed_mps,
        state.yaw_rate_rad_s,
        state.obeyed[0],
        state.obeyed[3],
        free_m,
        interval_s,
    )
    step_m = (state.place_m[0] - x_m) * np.cos(yaw_rad) + (state.place_m[1] - y_m) * np.sin(yaw_rad)
    add_up(state.odometry, state.odometry_scales, step_m, state.yaw_rad - yaw_rad, rng)


@record_kernel()
def look_ahead(state: Any, rng: np.random.Generator) -> None:
    """Write the camera's pose, true with shaking, and as measured."""
    for axis in range(2):
        fresh = np.sqrt(1.0 - NOD_KEPT**2) * NOD_RAD * rng.standard_normal()
        state.shake_rad[axis] = NOD_KEPT * state.shake_rad[axis] + fresh
    turn_down(state.R, state.yaw_rad, _HALF_TURN_RAD + state.shake_rad[0], state.shake_rad[1])
    turn_down(state.R_measured, state.odometry[2], _HALF_TURN_RAD, 0.0)
    for axis in range(2):
        state.camera_m[axis], state.camera_measured_m[axis] = state.place_m[axis], state.odometry[axis]
    state.camera_m[2] = state.camera_measured_m[2] = CAMERA_HEIGHT_M


_NEAREST_M, _FARTHEST_M = 0.5, 8.0
"""The tracker may confuse people at these distances with the target."""


class Drives(NamedTuple):
    """Planned drives as arrays, see ``StereoPictureless.arrays``, and the constants of their simulation.

    Attributes:
        errors: (1,) of dtype ``ERRORS``. camera, interval_s: see ``World``.
    """

    target_m: NDArray[np.float64]
    target_rad: NDArray[np.float64]
    size_m: NDArray[np.float64]
    others_m: NDArray[np.float64]
    free_m: NDArray[np.float64]
    openings_m: NDArray[np.float64]
    path_m: NDArray[np.float64]
    yaw_rad: NDArray[np.float64]
    onsets: NDArray[np.float64]
    errors: NDArray[np.void]
    camera: NDArray[np.float64]
    interval_s: float


@record_kernel()
def begin_drives(
    states: Any,
    which: NDArray[np.int64],
    episodes: NDArray[np.int64],
    at_losses: bool,
    drives: Any,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Begin ``episodes`` (K,) in the rows ``which`` (K,) of ``states``: on frame 0, or shortly before a likely loss."""
    target_m, target_rad, size_m = drives.target_m, drives.target_rad, drives.size_m
    others_m, openings_m, errors, camera = drives.others_m, drives.openings_m, drives.errors[0], drives.camera
    path_m, yaw_rad, interval_s = drives.path_m, drives.yaw_rad, drives.interval_s
    for n in range(len(which)):
        state, episode = states[which[n]], episodes[n]
        frame = begin_state(state, episode, drives.onsets[episode], at_losses, rng)
        for axis in range(2):
            state.place_m[axis] = path_m[episode, frame, axis]
            state.shake_rad[axis] = 0.0
        state.place_m[2] = 0.0
        state.yaw_rad = yaw_rad[episode, frame]
        state.speed_mps = state.yaw_rate_rad_s = 0.0
        for axis in range(3):
            state.odometry[axis] = 0.0
        state.odometry_scales[0] = 1.0 + SCALE_ERROR * rng.standard_normal()
        state.odometry_scales[1] = 1.0 + TURN_SCALE_ERROR * rng.standard_normal()
        if at_losses:
            east_m = path_m[episode, frame + 1, 0] - path_m[episode, frame, 0]
            north_m = path_m[episode, frame + 1, 1] - path_m[episode, frame, 1]
            state.speed_mps = np.hypot(east_m, north_m) / interval_s
            state.yaw_rate_rad_s = (yaw_rad[episode, frame + 1] - yaw_rad[episode, frame]) / interval_s
        for axis in range(4):
            state.command[axis] = state.obeyed[axis] = 0.0
        state.command[0] = state.obeyed[0] = state.speed_mps
        state.command[3] = state.obeyed[3] = state.yaw_rate_rad_s
        start_tracker(state, rng)
        _observe(state, target_m, target_rad, size_m, others_m, openings_m, errors, camera, sightings[which[n]], rng)


@record_kernel()
def drive_on(
    states: Any, wanted: Any, waiting: Any, link: LinkLimits, drives: Any, sightings: Any, rng: np.random.Generator
) -> None:
    """Advance all states by one frame under the commands (B, 4), and write their sightings."""
    target_m, target_rad, size_m = drives.target_m, drives.target_rad, drives.size_m
    others_m, openings_m, errors, camera = drives.others_m, drives.openings_m, drives.errors[0], drives.camera
    free_m, interval_s = drives.free_m, drives.interval_s
    for k in range(len(states)):
        state = states[k]
        send(state, wanted[k], link, waiting[k], rng)
        drive(state, free_m[state.episode], interval_s, rng)
        state.frame += 1
        state.steps += 1
        _observe(state, target_m, target_rad, size_m, others_m, openings_m, errors, camera, sightings[k], rng)


@record_kernel()
def _observe(
    state: Any,
    target_m: Any,
    target_rad: Any,
    size_m: Any,
    others_m: Any,
    openings_m: Any,
    errors: Any,
    camera: Any,
    sighting: Any,
    rng: np.random.Generator,
) -> None:
    """Write the truth of the current frame, the tracker's answer, and the sighting.

    Arrays are those of ``Drives``, one by one: each read of a tuple's array counts a reference, a tenth of a step.
    """
    episode = state.episode
    place_target(state, target_m, target_rad)
    look_ahead(state, rng)
    people_m, doors_m = others_m[episode, state.frame], openings_m[episode]
    _notice_others(state, people_m, doors_m, camera)
    look(state, size_m[episode], camera, covered_share(state.place_m, state.target_m, people_m, doors_m))
    count_out(state)
    sight_rad = np.arctan2(state.target_m[1] - state.camera_m[1], state.target_m[0] - state.camera_m[0])
    track(state, errors, size_m[episode], sight_rad, camera, rng)
    write_sighting_ahead(state, camera, sighting)


@record_kernel()
def _notice_others(state: Any, others_m: NDArray[np.float64], openings_m: Any, camera: Any) -> None:
    """Note which person the tracker confuses, or would confuse, with the target: the nearest one in sight."""
    if state.mode != WRONG:
        state.other, nearest_m = NO_OTHER, _FARTHEST_M
        for n in range(len(others_m)):
            away_m = np.hypot(others_m[n, 0] - state.place_m[0], others_m[n, 1] - state.place_m[1])
            if away_m < nearest_m and _is_in_sight(state, others_m[n], openings_m, camera):
                state.other, nearest_m = n, away_m
    elif state.other >= 0 and not _is_in_sight(state, others_m[state.other], openings_m, camera):
        state.other = NO_OTHER
    if state.other >= 0:
        state.other_offset_m[0] = others_m[state.other, 0] - state.target_m[0]
        state.other_offset_m[1] = others_m[state.other, 1] - state.target_m[1]


@record_kernel()
def _is_in_sight(state: Any, place_m: NDArray[np.float64], openings_m: Any, camera: Any) -> bool:
    """Return whether a place (2,) is in the picture, within range and not behind a wall."""
    right_m, _, ahead_m = in_camera(state.R, state.camera_m, place_m[0], place_m[1], CAMERA_HEIGHT_M)
    if not _NEAREST_M < ahead_m < _FARTHEST_M or abs(right_m) * camera[0] > ahead_m * camera[1]:
        return False
    return not is_walled(state.place_m[0], state.place_m[1], place_m[0], place_m[1], openings_m)


class StereoWorld(KernelWorld):
    """See ``KernelWorld``."""

    state_dtype = DRIVE_STATE
    begin_kernel, move_kernel = staticmethod(begin_drives), staticmethod(drive_on)

    def __init__(
        self, preset: StereoFollow, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        numbers = camera_numbers(camera(preset.width_px, preset.height_px))
        super().__init__(Drives(**arrays, errors=errors, camera=numbers, interval_s=1.0 / preset.rate_hz), link)
