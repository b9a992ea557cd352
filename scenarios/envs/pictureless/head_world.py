"""Steered heads beside a camera at rest, which the tracker watches, without pictures."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits, send
from scenarios.envs.pictureless.episode_state import (
    ANSWER,
    NO_OTHER,
    KernelWorld,
    begin_state,
    measured_camera,
    state_dtype,
)
from scenarios.envs.pictureless.error_kernel import start_tracker, track
from scenarios.envs.pictureless.error_model import WRONG
from scenarios.envs.pictureless.poses import ground_depth_m, in_camera, on_ground
from scenarios.envs.pictureless.sight_kernel import count_out, look, place_target
from trackers.belief.sighting import FARTHEST_M
from trackers.kernels.records import record_kernel
from trackers.types import HEAD_COMMANDS, SteeredCamera

HEAD_STATE = state_dtype(("head", "f8", (3,)), ("rates", "f8", (3,)), ("lens", "f8", (3,)))
"""State of a head: pan, tilt, and zoom, their rates (of the zoom's logarithm), and the camera at the zoom, see
``camera_numbers``; ``R`` and ``camera_m`` are those of the head's camera.
"""
AXES = np.array([HEAD_COMMANDS.index(name) for name in ("pan_rad_s", "tilt_rad_s", "zoom_per_s")])
"""Place of each of the head's commands among those obeyed."""
PAN, TILT, ZOOM = range(3)


@record_kernel()
def turn_head(
    state: Any,
    lens: NDArray[np.float64],
    lowest: NDArray[np.float64],
    highest: NDArray[np.float64],
    link: LinkLimits,
    interval_s: float,
) -> None:
    """Obey ``state.obeyed`` for one frame, as ``scenarios.pan_tilt_zoom.Head``.

    Args:
        lens: (3,) the camera at zoom 1. lowest, highest: (3,) of pan, tilt and zoom.
    """
    for k in range(3):
        limit, step = link.limits[AXES[k]], link.steps[AXES[k]]
        wanted = min(max(state.obeyed[AXES[k]], -limit), limit)
        state.rates[k] += min(max(wanted - state.rates[k], -step), step)
    state.head[PAN] += state.rates[PAN] * interval_s
    state.head[TILT] += state.rates[TILT] * interval_s
    state.head[ZOOM] *= np.exp(state.rates[ZOOM] * interval_s)
    for k in range(3):
        state.head[k] = min(max(state.head[k], lowest[k]), highest[k])
    _focus(state, lens)


@record_kernel()
def _focus(state: Any, lens: NDArray[np.float64]) -> None:
    state.lens[0], state.lens[1], state.lens[2] = lens[0] * state.head[ZOOM], lens[1], lens[2]


@record_kernel()
def look_around(state: Any, axes: NDArray[np.float64], place_m: NDArray[np.float64]) -> None:
    """Write the pose of the head's camera.

    Args:
        axes: (3, 3) rows ahead at pan and tilt 0, left, up. place_m: (3,) of the camera.
    """
    c, s = np.cos(state.head[PAN]), np.sin(state.head[PAN])
    ct, st = np.cos(state.head[TILT]), np.sin(state.head[TILT])
    for i in range(3):
        ahead = c * axes[0, i] + s * axes[1, i]
        state.R[i, 0] = s * axes[0, i] - c * axes[1, i]
        state.R[i, 1] = st * ahead - ct * axes[2, i]
        state.R[i, 2] = ct * ahead + st * axes[2, i]
        state.camera_m[i] = place_m[i]


@record_kernel()
def write_sighting_around(
    state: Any,
    surveyed: NDArray[np.float64],
    watched: NDArray[np.float64],
    measured_m: NDArray[np.float64],
    sighting: Any,
) -> None:
    """Write the record ``SIGHTING`` of a steered head, as ``trackers.belief.sighting`` does.

    Args:
        surveyed: (3, 4) measured pose of the camera that the tracker watches. watched: (3,) that camera.
        measured_m: (3,) measured place of the head's camera, whose measured orientation is ``state.R``.
    """
    R, lens = state.R, state.lens
    # The optical axis in the ground plane, at any tilt.
    heading_rad = np.arctan2(R[1, 2] + R[2, 2] * R[1, 1], R[0, 2] + R[2, 2] * R[0, 1])
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    sighting.carrier_x_m, sighting.carrier_y_m, sighting.height_m = measured_m[0], measured_m[1], measured_m[2]
    sighting.heading_rad = heading_rad
    east_m, north_m = on_ground(R, measured_m[2], 0.0, 0.0, FARTHEST_M)
    sighting.axis_ahead_m, sighting.axis_right_m = c * east_m + s * north_m, s * east_m - c * north_m
    sighting.axis_depth_m = ground_depth_m(R, measured_m[2], 0.0, 0.0)
    reach_m = np.hypot(np.hypot(east_m, north_m), measured_m[2])
    sighting.half_right_m, sighting.half_ahead_m = reach_m * lens[1] / lens[0], reach_m * lens[2] / lens[0]
    sighting.known = state.known
    sighting.x_m = sighting.y_m = sighting.spread_m = sighting.densest_x_m = sighting.densest_y_m = (
        sighting.densest_share
    ) = 0.0
    sighting.in_view_probability = sighting.picture_x = sighting.picture_y = sighting.length_share = 0.0
    sighting.depth_m = 0.0
    if state.known == 0.0:
        return
    right, down = (state.estimate_px[0] - watched[1]) / watched[0], (state.estimate_px[1] - watched[2]) / watched[0]
    turned, height_m = surveyed[:, :3], surveyed[2, 3]
    east_m, north_m = on_ground(turned, height_m, right, down, FARTHEST_M)
    sighting.depth_m = ground_depth_m(turned, height_m, right, down)
    sighting.x_m, sighting.y_m = surveyed[0, 3] + east_m, surveyed[1, 3] + north_m
    sighting.in_view_probability = state.probability
    sighting.spread_m, sighting.densest_share = state.spread_m, state.densest_share
    sighting.densest_x_m = sighting.x_m + state.densest_offset_m[0]
    sighting.densest_y_m = sighting.y_m + state.densest_offset_m[1]
    # Into the head's picture, over the ground; what is beside or behind the camera is far outside it.
    x_m, y_m, z_m = in_camera(R, measured_m, sighting.x_m, sighting.y_m, 0.0)
    depth_m = max(z_m, 1e-3 * np.sqrt(x_m * x_m + y_m * y_m + z_m * z_m), 1e-9)
    sighting.picture_x = x_m / depth_m * lens[0] / lens[1]
    sighting.picture_y = y_m / depth_m * lens[0] / lens[2]
    away_m = np.hypot(np.hypot(east_m, north_m), height_m)
    sighting.length_share = state.length_share * (away_m * watched[1] / watched[0]) / (depth_m * lens[1] / lens[0])


class Heads(NamedTuple):
    """Planned episodes as arrays, see ``HeadPictureless.arrays``, and the constants of their simulation.

    Attributes:
        answers: (E, T) of dtype ``ANSWER``, a tracker's own in these episodes; T = 0: the error model draws them.
        errors: (1,) of dtype ``ERRORS``. camera, interval_s: see ``KernelWorld``.
    """

    target_m: NDArray[np.float64]
    target_rad: NDArray[np.float64]
    size_m: NDArray[np.float64]
    seen_m: NDArray[np.float64]
    hidden: NDArray[np.float64]
    others_m: NDArray[np.float64]
    onsets: NDArray[np.float64]
    watched: NDArray[np.float64]
    watched_pose: NDArray[np.float64]
    surveyed_pose: NDArray[np.float64]
    lens: NDArray[np.float64]
    place_m: NDArray[np.float64]
    measured_m: NDArray[np.float64]
    axes: NDArray[np.float64]
    first: NDArray[np.float64]
    lowest: NDArray[np.float64]
    highest: NDArray[np.float64]
    answers: NDArray[np.void]
    errors: NDArray[np.void]
    camera: NDArray[np.float64]
    interval_s: float


_ASIDE = 0.5
"""Standard deviation of the target's first place in the picture, in halves of it, in an episode that begins late."""


@record_kernel()
def begin_heads(
    states: Any,
    which: NDArray[np.int64],
    episodes: NDArray[np.int64],
    at_losses: bool,
    heads: Any,
    sightings: Any,
    rng: np.random.Generator,
) -> None:
    """Begin ``episodes`` (K,) in the rows ``which`` (K,) of ``states``: on frame 0, or shortly before a likely loss."""
    for n in range(len(which)):
        state, episode = states[which[n]], episodes[n]
        frame = begin_state(state, episode, heads.onsets[episode], at_losses, rng)
        for k in range(3):
            state.head[k], state.rates[k] = heads.first[episode, k], 0.0
        if at_losses:
            _aim_near(state, heads, frame, rng)
        _focus(state, heads.lens[episode])
        for axis in range(4):
            state.command[axis] = state.obeyed[axis] = 0.0
        start_tracker(state, rng)
        _observe(state, heads, sightings[which[n]], rng)


@record_kernel()
def _aim_near(state: Any, heads: Any, frame: int, rng: np.random.Generator) -> None:
    """Turn the head so that the target is somewhere in its picture."""
    episode, axes = state.episode, heads.axes[state.episode]
    away = np.zeros(3)
    for row in range(3):
        for i in range(3):
            away[row] += axes[row, i] * (heads.seen_m[episode, frame, i] - heads.place_m[episode, i])
    half = heads.lens[episode, 1] / heads.lens[episode, 0] / state.head[ZOOM]
    state.head[PAN] = np.arctan2(away[1], away[0]) + _ASIDE * half * rng.standard_normal()
    state.head[TILT] = np.arctan2(away[2], np.hypot(away[0], away[1])) + _ASIDE * half * rng.standard_normal()
    for k in range(3):
        state.head[k] = min(max(state.head[k], heads.lowest[episode, k]), heads.highest[episode, k])


@record_kernel()
def turn_on(
    states: Any, wanted: Any, waiting: Any, link: LinkLimits, heads: Any, sightings: Any, rng: np.random.Generator
) -> None:
    """Advance all states by one frame under the commands (B, 4), and write their sightings."""
    lens, lowest, highest = heads.lens, heads.lowest, heads.highest
    for k in range(len(states)):
        state = states[k]
        episode = state.episode
        send(state, wanted[k], link, waiting[k], rng)
        turn_head(state, lens[episode], lowest[episode], highest[episode], link, heads.interval_s)
        state.frame += 1
        state.steps += 1
        _observe(state, heads, sightings[k], rng)


@record_kernel(inline="always")
def _observe(state: Any, heads: Any, sighting: Any, rng: np.random.Generator) -> None:
    """Write the tracker's answer, the truth of the head's picture, and the sighting."""
    episode, frame = state.episode, state.frame
    size_m, watched = heads.size_m[episode], heads.watched[episode]
    place_target(state, heads.target_m, heads.target_rad)
    for i in range(3):
        state.camera_m[i] = heads.watched_pose[episode, i, 3]
        for j in range(3):
            state.R[i, j] = heads.watched_pose[episode, i, j]
    _notice_others(state, heads.others_m[episode, frame])
    look(state, size_m, watched, heads.hidden[episode, frame])
    if heads.answers.shape[1] > 0:
        _play(state, heads.answers[episode, frame])
    else:
        track(state, heads.errors[0], size_m, 0.0, watched, rng)
    place_target(state, heads.seen_m, heads.target_rad)
    look_around(state, heads.axes[episode], heads.place_m[episode])
    look(state, size_m, state.lens, heads.hidden[episode, frame])
    count_out(state)
    write_sighting_around(state, heads.surveyed_pose[episode], watched, heads.measured_m[episode], sighting)


@record_kernel()
def _play(state: Any, answer: Any) -> None:
    """Give the answer that the tracker itself gave on this frame."""
    state.known, state.probability, state.depth_m = answer.known, answer.probability, answer.depth_m
    state.length_share, state.spread_m, state.densest_share = answer.length_share, answer.spread_m, answer.densest_share
    for axis in range(2):
        state.estimate_px[axis] = answer.estimate_px[axis]
        state.densest_offset_m[axis] = answer.densest_offset_m[axis]
    state.error_px = np.hypot(state.estimate_px[0] - state.target_px[0], state.estimate_px[1] - state.target_px[1])


_NEAR_M = 1000.0
"""Objects that are farther away are absent, see ``HeadPictureless.arrays``."""


@record_kernel()
def _notice_others(state: Any, others_m: NDArray[np.float64]) -> None:
    """Note which object the tracker confuses, or would confuse, with the target: the nearest one."""
    if state.mode != WRONG:
        state.other, nearest_m = NO_OTHER, _NEAR_M
        for n in range(len(others_m)):
            away_m = np.hypot(others_m[n, 0] - state.target_m[0], others_m[n, 1] - state.target_m[1])
            if away_m < nearest_m:
                state.other, nearest_m = n, away_m
    if state.other >= 0:
        for axis in range(2):
            state.other_offset_m[axis] = others_m[state.other, axis] - state.target_m[axis]
        if np.hypot(state.other_offset_m[0], state.other_offset_m[1]) >= _NEAR_M:
            state.other = NO_OTHER


class HeadWorld(KernelWorld):
    """See ``KernelWorld``."""

    state_dtype = HEAD_STATE
    begin_kernel, move_kernel = staticmethod(begin_heads), staticmethod(turn_on)

    def __init__(
        self, preset: Any, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        lens, interval_s = arrays["lens"][0], 1.0 / preset.rate_hz
        none: dict[str, Any] = {"answers": np.zeros((len(arrays["lens"]), 0), ANSWER)}
        super().__init__(Heads(**none | arrays, errors=errors, camera=lens, interval_s=interval_s), link)

    def cameras(self, state: Any) -> tuple[SteeredCamera, SteeredCamera | None]:
        """See ``KernelWorld``."""
        heads, episode = self._data, state["episode"]
        surveyed = heads.surveyed_pose[episode]
        watched = measured_camera(heads.watched[episode], surveyed[:, :3], surveyed[:, 3])
        return watched, measured_camera(state["lens"], state["R"], heads.measured_m[episode])
