"""Draws a tracker's answers from its error model, one episode at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.envs.pictureless.episode_state import (
    ACROSS,
    ALONG,
    DENSEST_ACROSS,
    DENSEST_ALONG,
    DENSEST_SHARE,
    LATENTS,
    LENGTH,
    NO_OTHER,
    OTHER_UNKNOWN,
    PROBABILITY,
    SPREAD,
)
from scenarios.envs.pictureless.error_model import (
    CONDITION_FRAMES,
    CUT,
    KNOT_FRAMES,
    LONG_LOST_FRAMES,
    LOST,
    PLAIN,
    PLAIN_SHARE,
    QUANTILE_Z,
    SHAPES,
    TRACKING,
    UNSEEN,
    UNSEEN_SHARE,
    WRONG,
    ErrorModel,
)
from scenarios.envs.pictureless.poses import in_camera
from trackers.kernels.records import record_kernel

ERRORS = np.dtype(
    [
        ("looked_again", "f8"),
        ("in_picture", "f8"),
        ("fresh", "f8", SHAPES["kept"]),
        *((name, "f8", shape) for name, shape in SHAPES.items()),
    ],
    align=True,
)
"""A model's numbers; ``fresh`` are the standard deviations of the latent autoregressions' noise, ``in_picture`` is 1 if
errors lie in the plane of the picture, 0 if on the ground.
"""
_FIRST_Z, _Z_STEP, _QUANTILES = float(QUANTILE_Z[0]), float(QUANTILE_Z[1] - QUANTILE_Z[0]), len(QUANTILE_Z)
_KNOTS = np.array(KNOT_FRAMES)
_SINCE = np.array(CONDITION_FRAMES)
_NEAREST_M = 1e-3


def error_record(model: ErrorModel) -> NDArray[np.void]:
    """Return a model as a record (1,) of dtype ``ERRORS`` for kernels."""
    record = np.zeros(1, ERRORS)
    for name in ("looked_again", *SHAPES):
        record[name][0] = getattr(model, name)
    record["in_picture"][0] = catalog.scenario(model.scenario).carrier.looks == "around"
    record["fresh"][0] = np.sqrt(1.0 - np.minimum(model.kept**2, 1.0))
    return record


@record_kernel()
def start_tracker(state: Any, rng: np.random.Generator) -> None:
    """Start the tracker on its target."""
    state.mode, state.condition, state.condition_frames, state.unsure_frames = TRACKING, PLAIN, 0, 0
    state.other = OTHER_UNKNOWN
    for latent in range(LATENTS):
        state.latent[latent] = rng.standard_normal()


@record_kernel()
def track(state: Any, errors: Any, size_m: Any, axis_rad: float, camera: Any, rng: np.random.Generator) -> None:
    """Draw the tracker's answer on a frame whose truth, in the picture that it watches, is in ``state``.

    Args:
        axis_rad: axis of the errors: the target's heading, or the direction of the line of sight; of a camera that
            looks around no matter.
        camera: focal length, half width, half height, pixels.
    """
    _notice_condition(state)
    before = state.mode
    state.mode = _next_mode(state, errors, rng)
    if state.mode == WRONG and state.other == NO_OTHER:
        state.mode = LOST
    _age(state, axis_rad)
    mode = state.mode
    if mode == before:
        for latent in range(LATENTS):
            state.latent[latent] = (
                errors.kept[mode, latent] * state.latent[latent] + errors.fresh[mode, latent] * rng.standard_normal()
            )
    elif before != TRACKING or mode != LOST:
        # On another target, or on the right one again, all errors are drawn anew; on a loss they continue.
        for latent in range(LATENTS):
            state.latent[latent] = rng.standard_normal()
    low, share = _knot(state)
    _answer(state, errors, size_m, camera, low, share)
    in_picture = _is_in_picture(state, camera)
    if in_picture and mode == LOST and state.condition == UNSEEN and rng.random() < errors.looked_again:
        state.latent[ALONG], state.latent[ACROSS] = rng.standard_normal(), rng.standard_normal()
        _answer(state, errors, size_m, camera, low, share)
        in_picture = _is_in_picture(state, camera)
    state.probability = _at(errors.probability[mode, 1 if in_picture else 0], state.latent[PROBABILITY])
    state.error_px = np.hypot(state.estimate_px[0] - state.target_px[0], state.estimate_px[1] - state.target_px[1])


@record_kernel()
def _is_in_picture(state: Any, camera: Any) -> bool:
    return abs(state.estimate_px[0] - camera[1]) < camera[1] and abs(state.estimate_px[1] - camera[2]) < camera[2]


@record_kernel()
def _notice_condition(state: Any) -> None:
    condition = PLAIN if state.visible >= PLAIN_SHARE else UNSEEN if state.visible < UNSEEN_SHARE else CUT
    state.condition_frames = state.condition_frames + 1 if condition == state.condition else 0
    state.condition = condition


@record_kernel()
def _next_mode(state: Any, errors: Any, rng: np.random.Generator) -> int:
    row = 0
    for k in range(1, len(_SINCE)):
        if state.condition_frames >= _SINCE[k]:
            row = k
    rates = errors.rates[state.condition, row, 1 if state.unsure_frames > LONG_LOST_FRAMES else 0, state.mode]
    drawn = rng.random()
    for mode in range(2):
        drawn -= rates[mode]
        if drawn < 0.0:
            return mode
    return 2


@record_kernel()
def _age(state: Any, axis_rad: float) -> None:
    """Count the frames since the target was last tracked, and keep the axis of that frame."""
    if state.mode == TRACKING:
        state.unsure_frames, state.axis_rad = 0, axis_rad
    else:
        state.unsure_frames += 1


@record_kernel()
def _knot(state: Any) -> tuple[int, float]:
    """Return the lower knot of the current distribution, and the share of the next knot."""
    if state.mode == TRACKING:
        return state.condition, 0.0
    frames = min(max(float(state.unsure_frames), _KNOTS[0]), _KNOTS[-1])
    low = 0
    for k in range(1, len(_KNOTS) - 1):
        if frames >= _KNOTS[k]:
            low = k
    return low, (frames - _KNOTS[low]) / (_KNOTS[low + 1] - _KNOTS[low])


@record_kernel()
def _answer(state: Any, errors: Any, size_m: Any, camera: Any, low: int, share: float) -> None:
    """Write the tracker's answer, except the probability."""
    mode, latent = state.mode, state.latent
    c, s = np.cos(state.axis_rad), np.sin(state.axis_rad)
    x_m, y_m = state.target_m[0], state.target_m[1]
    followed = mode
    if mode == WRONG and state.other >= 0:
        # On another person, whose path is known, it is as exact as on its target.
        x_m, y_m, followed, low, share = x_m + state.other_offset_m[0], y_m + state.other_offset_m[1], TRACKING, 0, 0.0
    along_m = _between(errors.error_m[0, followed], low, share, latent[ALONG])
    across_m = _between(errors.error_m[1, followed], low, share, latent[ACROSS])
    if errors.in_picture == 0.0:
        x_m, y_m = x_m + c * along_m - s * across_m, y_m + s * along_m + c * across_m
    z_m = state.target_m[2] + 0.5 * size_m[2]
    right_m, down_m, depth_m = in_camera(state.R, state.camera_m, x_m, y_m, z_m)
    if errors.in_picture > 0.0:
        right_m, down_m = right_m + along_m, down_m + across_m
    known_share = errors.known_share[mode, low]
    if share > 0.0:
        known_share += share * (errors.known_share[mode, low + 1] - known_share)
    state.known = 1.0 if depth_m > _NEAREST_M and _normal_share(latent[LENGTH]) < known_share else 0.0
    depth_m = max(depth_m, _NEAREST_M)
    state.depth_m = depth_m
    state.estimate_px[0] = camera[1] + camera[0] * right_m / depth_m
    state.estimate_px[1] = camera[2] + camera[0] * down_m / depth_m
    longest_m = max(size_m[0], size_m[2])
    state.length_share = 0.5 * camera[0] * longest_m / depth_m / camera[1] * _at(errors.length[mode], latent[LENGTH])
    state.spread_m = max(_between(errors.spread_m[mode], low, share, latent[SPREAD]), 0.0)
    densest_share = _between(errors.densest_share[mode], low, share, latent[DENSEST_SHARE])
    state.densest_share = min(max(densest_share, 0.0), 1.0)
    along_m = state.spread_m * _at(errors.densest_offset[0, mode], latent[DENSEST_ALONG])
    across_m = state.spread_m * _at(errors.densest_offset[1, mode], latent[DENSEST_ACROSS])
    state.densest_offset_m[0], state.densest_offset_m[1] = c * along_m - s * across_m, s * along_m + c * across_m


@record_kernel()
def _between(quantiles: NDArray[np.float64], low: int, share: float, z: float) -> float:
    value = _at(quantiles[low], z)
    return value if share == 0.0 else value + share * (_at(quantiles[low + 1], z) - value)


@record_kernel()
def _at(quantiles: NDArray[np.float64], z: float) -> float:
    """Return the quantile at ``z`` of the standard normal distribution, clamped to the outermost ones."""
    place = min(max((z - _FIRST_Z) / _Z_STEP, 0.0), _QUANTILES - 1.000001)
    low = int(place)
    return quantiles[low] + (place - low) * (quantiles[low + 1] - quantiles[low])


@record_kernel()
def _normal_share(z: float) -> float:
    """Return the standard normal distribution at z, to 2 parts in 1,000 (the logistic approximation)."""
    return 1.0 / (1.0 + np.exp(-1.5976 * z - 0.07056 * z * z * z))
