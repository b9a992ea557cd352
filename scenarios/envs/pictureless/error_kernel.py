"""A tracker's answers drawn from its error model, one episode at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.envs.pictureless.error_model import (
    CONDITION_FRAMES,
    CUT,
    KNOT_FRAMES,
    LONG_LOST_FRAMES,
    LOST,
    PLAIN,
    PLAIN_SHARE,
    QUANTILE_Z,
    TRACKING,
    UNSEEN,
    UNSEEN_SHARE,
    WRONG,
    ErrorModel,
)
from scenarios.envs.pictureless.life import (
    ACROSS,
    ALONG,
    ANYTHING,
    DENSEST_ACROSS,
    DENSEST_ALONG,
    DENSEST_SHARE,
    LATENTS,
    LENGTH,
    NOBODY,
    PROBABILITY,
    SPREAD,
)
from scenarios.envs.pictureless.poses import in_camera

ERRORS = np.dtype(
    [
        ("rates", "f8", (3, len(CONDITION_FRAMES), 2, 3, 3)),
        ("kept", "f8", (3, LATENTS)),
        ("fresh", "f8", (3, LATENTS)),
        ("error_m", "f8", (2, 3, len(KNOT_FRAMES), len(QUANTILE_Z))),
        ("spread_m", "f8", (3, len(KNOT_FRAMES), len(QUANTILE_Z))),
        ("densest_share", "f8", (3, len(KNOT_FRAMES), len(QUANTILE_Z))),
        ("densest_offset", "f8", (2, 3, len(QUANTILE_Z))),
        ("probability", "f8", (3, 2, len(QUANTILE_Z))),
        ("length", "f8", (3, len(QUANTILE_Z))),
        ("known_share", "f8", (3, len(KNOT_FRAMES))),
        ("looked_again", "f8"),
    ],
    align=True,
)
_FIRST_Z, _Z_STEP, _QUANTILES = float(QUANTILE_Z[0]), float(QUANTILE_Z[1] - QUANTILE_Z[0]), len(QUANTILE_Z)
_KNOTS = np.array(KNOT_FRAMES)
_SINCE = np.array(CONDITION_FRAMES)
_NEAREST_M = 1e-3


def error_record(model: ErrorModel) -> NDArray[np.void]:
    """Return a model (1,) of dtype ``ERRORS``, as kernels read it."""
    record = np.zeros(1, ERRORS)
    for name in ERRORS.names or ():
        if name != "fresh":
            record[name][0] = getattr(model, name)
    record["fresh"][0] = np.sqrt(1.0 - np.minimum(model.kept**2, 1.0))
    return record


@njit(cache=True)
def start_tracker(life: Any, rng: np.random.Generator) -> None:
    """Put the tracker on its target."""
    life.mode, life.condition, life.condition_frames, life.unsure_frames = TRACKING, PLAIN, 0, 0
    life.other = ANYTHING
    for latent in range(LATENTS):
        life.latent[latent] = rng.standard_normal()


@njit(cache=True)
def track(life: Any, errors: Any, size_m: Any, axis_rad: float, camera: Any, rng: np.random.Generator) -> None:
    """Let the tracker answer on a frame whose truth stands in ``life``.

    Args:
        axis_rad: direction along which errors are drawn now: the target's heading, or that of the line of sight.
        camera: focal length, half width, half height, pixels.
    """
    _notice_condition(life)
    before = life.mode
    life.mode = _next_mode(life, errors, rng)
    if life.mode == WRONG and life.other == NOBODY:
        life.mode = LOST
    _age(life, axis_rad)
    mode = life.mode
    if mode == before:
        for latent in range(LATENTS):
            life.latent[latent] = (
                errors.kept[mode, latent] * life.latent[latent] + errors.fresh[mode, latent] * rng.standard_normal()
            )
    elif before != TRACKING or mode != LOST:
        # Another target, or the right one again: all is new. Who is just lost goes on from where he was.
        for latent in range(LATENTS):
            life.latent[latent] = rng.standard_normal()
    low, share = _knot(life)
    _answer(life, errors, size_m, camera, low, share)
    in_picture = abs(life.estimate_px[0] - camera[1]) < camera[1] and abs(life.estimate_px[1] - camera[2]) < camera[2]
    if in_picture and mode == LOST and life.condition == UNSEEN and rng.random() < errors.looked_again:
        life.latent[ALONG], life.latent[ACROSS] = rng.standard_normal(), rng.standard_normal()
        _answer(life, errors, size_m, camera, low, share)
        in_picture = (
            abs(life.estimate_px[0] - camera[1]) < camera[1] and abs(life.estimate_px[1] - camera[2]) < camera[2]
        )
    life.probability = _at(errors.probability[mode, 1 if in_picture else 0], life.latent[PROBABILITY])


@njit(cache=True)
def _notice_condition(life: Any) -> None:
    condition = PLAIN if life.visible >= PLAIN_SHARE else UNSEEN if life.visible < UNSEEN_SHARE else CUT
    life.condition_frames = life.condition_frames + 1 if condition == life.condition else 0
    life.condition = condition


@njit(cache=True)
def _next_mode(life: Any, errors: Any, rng: np.random.Generator) -> int:
    row = 0
    for k in range(1, len(_SINCE)):
        if life.condition_frames >= _SINCE[k]:
            row = k
    rates = errors.rates[life.condition, row, 1 if life.unsure_frames > LONG_LOST_FRAMES else 0, life.mode]
    drawn = rng.random()
    for mode in range(2):
        drawn -= rates[mode]
        if drawn < 0.0:
            return mode
    return 2


@njit(cache=True)
def _age(life: Any, axis_rad: float) -> None:
    """Count frames since the target was tracked, and keep the axis of that moment."""
    if life.mode == TRACKING:
        life.unsure_frames, life.axis_rad = 0, axis_rad
    else:
        life.unsure_frames += 1


@njit(cache=True)
def _knot(life: Any) -> tuple[int, float]:
    """Return between which distributions the present one lies: the lower knot, and the share of the next."""
    if life.mode == TRACKING:
        return life.condition, 0.0
    frames = min(max(float(life.unsure_frames), _KNOTS[0]), _KNOTS[-1])
    low = 0
    for k in range(1, len(_KNOTS) - 1):
        if frames >= _KNOTS[k]:
            low = k
    return low, (frames - _KNOTS[low]) / (_KNOTS[low + 1] - _KNOTS[low])


@njit(cache=True)
def _answer(life: Any, errors: Any, size_m: Any, camera: Any, low: int, share: float) -> None:
    """Write what the tracker says, all but the probability."""
    mode, latent = life.mode, life.latent
    c, s = np.cos(life.axis_rad), np.sin(life.axis_rad)
    x_m, y_m = life.target_m[0], life.target_m[1]
    followed = mode
    if mode == WRONG and life.other >= 0:
        # On somebody whose way is known it is as exact as on its target.
        x_m, y_m, followed, low, share = x_m + life.other_offset_m[0], y_m + life.other_offset_m[1], TRACKING, 0, 0.0
    along_m = _between(errors.error_m[0, followed], low, share, latent[ALONG])
    across_m = _between(errors.error_m[1, followed], low, share, latent[ACROSS])
    x_m, y_m = x_m + c * along_m - s * across_m, y_m + s * along_m + c * across_m
    right_m, down_m, depth_m = in_camera(life.R, life.camera_m, x_m, y_m, 0.5 * size_m[2])
    known_share = errors.known_share[mode, low]
    if share > 0.0:
        known_share += share * (errors.known_share[mode, low + 1] - known_share)
    life.known = 1.0 if depth_m > _NEAREST_M and _normal_share(latent[LENGTH]) < known_share else 0.0
    depth_m = max(depth_m, _NEAREST_M)
    life.depth_m = depth_m
    life.estimate_px[0] = camera[1] + camera[0] * right_m / depth_m
    life.estimate_px[1] = camera[2] + camera[0] * down_m / depth_m
    longest_m = max(size_m[0], size_m[2])
    life.length_share = 0.5 * camera[0] * longest_m / depth_m / camera[1] * _at(errors.length[mode], latent[LENGTH])
    life.spread_m = max(_between(errors.spread_m[mode], low, share, latent[SPREAD]), 0.0)
    densest_share = _between(errors.densest_share[mode], low, share, latent[DENSEST_SHARE])
    life.densest_share = min(max(densest_share, 0.0), 1.0)
    along_m = life.spread_m * _at(errors.densest_offset[0, mode], latent[DENSEST_ALONG])
    across_m = life.spread_m * _at(errors.densest_offset[1, mode], latent[DENSEST_ACROSS])
    life.densest_offset_m[0], life.densest_offset_m[1] = c * along_m - s * across_m, s * along_m + c * across_m


@njit(cache=True)
def _between(quantiles: NDArray[np.float64], low: int, share: float, z: float) -> float:
    value = _at(quantiles[low], z)
    return value if share == 0.0 else value + share * (_at(quantiles[low + 1], z) - value)


@njit(cache=True)
def _at(quantiles: NDArray[np.float64], z: float) -> float:
    """Return the quantile at a place of the standard normal distribution, no further out than the outermost."""
    place = min(max((z - _FIRST_Z) / _Z_STEP, 0.0), _QUANTILES - 1.000001)
    low = int(place)
    return quantiles[low] + (place - low) * (quantiles[low + 1] - quantiles[low])


@njit(cache=True)
def _normal_share(z: float) -> float:
    """Return the standard normal distribution at z, to 2 parts in 1,000 (the logistic approximation)."""
    return 1.0 / (1.0 + np.exp(-1.5976 * z - 0.07056 * z * z * z))
