"""Where a swimmer goes after its track breaks off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from trackers.swimmer.features import POSTURE_FEATURES, Pasts, activity, features, smoothness
from trackers.swimmer.regression import Regression, Samples
from trackers.swimmer.steady import steady_way
from trackers.swimmer.windows import Recording

KNOTS = (2, 5, 12, 25, 50, 100, 200)
"""Numbers of frames ahead for which a regression is learnt; between them the way is interpolated, then it stands."""


def samples_ahead(recording: Recording, ahead: int) -> Samples:
    """Return the steps within ``ahead`` frames that a recording shows."""
    windows = recording.windows(ahead, 0)
    pasts = windows.pasts
    step = (windows.gap_px[:, -1] - pasts.last_px) / pasts.unit_px
    scales = scales_ahead(pasts)
    features_ahead = features(pasts, np.array([float(ahead)]))[0]
    return Samples(features_ahead, step, scales, windows.weight, windows.fold, windows.independent, POSTURE_FEATURES)


def scales_ahead(pasts: Pasts) -> NDArray[np.float64]:
    """Return (M, 6) scales of the error: constant, and with the way and the speed, of rough and smooth pasts."""
    x, unit = pasts.position_px, pasts.unit_px[:, 0]
    smooth, active = smoothness(x), activity(pasts)
    swift = np.linalg.norm(x[:, -1] - x[:, -7], axis=1) / unit
    rough = 1.0 - smooth
    return np.stack([rough, rough * active, rough * swift, smooth * active, smooth * swift, 1.0 / unit], axis=1)


def way_ahead(
    regression: Callable[[int], Regression], pasts: Pasts, count: int, noise_px: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places (count, 2) on the frames after one past, and the radii (count,) that hold 95 %, in pixels.

    Places outside the bounds are moved onto them as far as the past is rough: a smooth one shows where it will go
    better than the bounds do. As far as it is steady, it goes on along its own curve.

    Args:
        regression: takes one of ``KNOTS`` to its regression.
        noise_px: standard deviation of a measured coordinate, > 0.
    """
    last, unit = pasts.last_px[0], float(pasts.unit_px[0, 0])
    knots = KNOTS[: int(np.searchsorted(KNOTS, count)) + 1]
    scales, seen = scales_ahead(pasts), features(pasts, np.array(knots, dtype=float))
    places, radii, frames = [last], [0.0], [0, *knots]
    for ahead, each in zip(knots, seen, strict=True):
        places.append(last + regression(ahead).step(each)[0] * unit)
        radii.append(float(regression(ahead).radius(scales)[0]) * unit)
    at = np.minimum(np.arange(1, count + 1), frames[-1])
    way = PchipInterpolator(frames, np.array(places))(at)
    within = np.clip(way, pasts.bounds_xyxy[0, :2], pasts.bounds_xyxy[0, 2:])
    smooth = float(smoothness(pasts.position_px)[0])
    way = within + smooth * (way - within)
    steady, curve, reach = steady_way(pasts.position_px[0], at, noise_px)
    return way + steady * (curve - way), (1 - steady) * np.interp(
        at, frames, np.maximum.accumulate(radii)
    ) + steady * reach
