"""Steady swimming: a past that one slight curve explains goes on along it.

Regressions over all kinds of swimming shrink a way and take its end from few frames; a slow fish that is measured with
noise needs all of its past.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_STEADY = 6.0
"""Root mean square distance of a past to its curve, over the noise of a coordinate, at which it counts half as steady.

Below 5 for the slow fish of preset ``paper-c`` on development seeds, above 14 for 99 % of the zebrafish's pasts.
"""
_DRIFT = 0.02
"""Standard deviation of the way, as a share of what its square in pasts makes of a past's way: how steadiness ends."""
_RADIUS_SIGMAS = float(np.sqrt(-2.0 * np.log(0.05)))


class SteadyWay(NamedTuple):
    """How a past goes on if it is steady.

    Attributes:
        weight: in [0, 1], 1 where the past is steady: where its noise explains how far it is off its curve.
        place_px: (G, 2). radius_px: (G,) of the circles that hold 95 %.
    """

    weight: float
    place_px: NDArray[np.float64]
    radius_px: NDArray[np.float64]


def steady_way(x: NDArray[np.float64], ahead: NDArray[np.float64], noise_px: float) -> SteadyWay:
    """Return the places ``ahead`` (G,) frames after a past (T, 2), px, of one frame after the other.

    The curve is of least squares: of constant speed along the past's direction, a parabola across it.

    Args:
        noise_px: standard deviation of a measured coordinate, > 0.
    """
    t = np.linspace(-1.0, 0.0, len(x))
    s = ahead / (len(x) - 1)
    past, future = (np.stack([np.ones_like(at), at + 0.5, (at + 0.5) ** 2], axis=1) for at in (t, s))
    straight, *_ = np.linalg.lstsq(past[:, :2], x, rcond=None)
    way_px = float(np.linalg.norm(straight[1]))
    along = straight[1] / max(way_px, 1e-9)
    across = np.array([-along[1], along[0]])
    curved, *_ = np.linalg.lstsq(past, x @ across, rcond=None)
    bend = curved - np.concatenate([straight @ across, [0.0]])
    fitted, place = (at[:, :2] @ straight + np.outer(at @ bend, across) for at in (past, future))
    rest_px = float(np.sqrt(((x - fitted) ** 2).sum(axis=1).mean()))
    leverage = np.einsum("gi,ij,gj->g", future, np.linalg.inv(past.T @ past), future)
    spread_px = np.sqrt(rest_px**2 * (1.0 + leverage) + (_DRIFT * way_px * s**2) ** 2)
    weight = 1.0 / (1.0 + (rest_px / (_STEADY * noise_px)) ** 4)
    return SteadyWay(weight, place, _RADIUS_SIGMAS * spread_px)
