"""Which way a long object points: weights of headings, by its motion and by the rectangle that it covers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.box_model import linearised
from trackers.site.view import SiteView

Array = NDArray[np.float64]

HEADINGS_RAD = np.arange(12) * np.pi / 12
"""A box looks the same from both ends."""

_TURNS = 0.03
"""Share that moves to each neighbour from picture to picture."""
_SIDE_PX, _SIDE_SHARE = 1.5, 0.08
"""Standard deviation of a rectangle's width and height: an edge is off by about a pixel; parts without contrast."""
_AGREES_RAD = 0.2
"""Standard deviation of a body's heading about its direction of travel."""
_FORGETS = 0.8
"""Successive pictures err alike."""


class Heading:
    """Probabilities (12,) of ``HEADINGS_RAD``."""

    def __init__(self) -> None:
        """All headings are as likely."""
        self._weights = np.full(len(HEADINGS_RAD), 1.0 / len(HEADINGS_RAD))

    @property
    def likeliest_rad(self) -> float:
        """The most likely heading, 0 to pi, as the mean of it and its neighbours on the doubled angle."""
        best = int(self._weights.argmax())
        near = np.arange(best - 1, best + 2) % len(HEADINGS_RAD)
        phase = np.exp(2j * HEADINGS_RAD[near]) @ self._weights[near]
        return float(np.angle(phase) / 2 % np.pi)

    def turn(self) -> None:
        """Let it turn from picture to picture."""
        w = self._weights
        self._weights = (1.0 - 2.0 * _TURNS) * w + _TURNS * (np.roll(w, 1) + np.roll(w, -1))

    def travel(self, velocity_mps: Array, covariance: Array) -> None:
        """Take in a velocity (2,) with its covariance (2, 2): a body points along it, as far as it surely moves."""
        along = np.column_stack([np.cos(HEADINGS_RAD), np.sin(HEADINGS_RAD)])
        across = np.column_stack([-along[:, 1], along[:, 0]])
        off = across @ velocity_mps
        spread = np.einsum("ki,ij,kj->k", across, covariance, across) + (_AGREES_RAD * (along @ velocity_mps)) ** 2
        self._weigh(-0.5 * off**2 / spread)

    def look(
        self,
        rectangle: Array,
        state: Array,
        covariance: Array,
        base_m: float,
        roof: tuple[float, float],
        view: SiteView,
    ) -> None:
        """Take in a rectangle (4,) of a box of state (7,): its sides are likelier at some headings than at others."""
        log = np.zeros(len(HEADINGS_RAD))
        for k, heading_rad in enumerate(HEADINGS_RAD):
            expected, jacobian = linearised(state, heading_rad, base_m, roof, view)
            sides, slope = expected[2:] - expected[:2], jacobian[2:, 4:] - jacobian[:2, 4:]
            noise = np.diag(_SIDE_PX**2 + (_SIDE_SHARE * sides) ** 2)
            spread = slope @ covariance[4:, 4:] @ slope.T + noise
            off = rectangle[2:] - rectangle[:2] - sides
            log[k] = -0.5 * off @ np.linalg.solve(spread, off) - 0.5 * np.log(np.linalg.det(spread))
        self._weigh(log)

    def _weigh(self, log: Array) -> None:
        weights = np.exp((1.0 - _FORGETS) * (log - log.max())) * self._weights
        self._weights = np.maximum(weights / weights.sum(), 1e-6)
