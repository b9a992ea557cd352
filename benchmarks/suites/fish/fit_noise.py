"""Finds the noise of ``ca_kalman`` by maximum likelihood on development swims."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from trackers.gaps.types import Piece
from trackers.paper_c.ca_kalman import CaKalmanParameters, log_likelihood


def fit_noise(tracks: Sequence[Piece]) -> CaKalmanParameters:
    """Return the parameters under which the tracks are most likely, to three digits."""
    start = CaKalmanParameters()

    def cost(logs: np.ndarray) -> float:
        parameters = CaKalmanParameters(*np.exp(logs))
        return -sum(log_likelihood(track, parameters) for track in tracks) / sum(len(t.position_px) for t in tracks)

    found = minimize(cost, np.log([start.jerk_px, start.measured_px]), method="Nelder-Mead", options={"xatol": 1e-3})
    return CaKalmanParameters(*(float(f"{value:.3g}") for value in np.exp(found.x)))
