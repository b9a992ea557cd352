"""The Kalman filter of constant acceleration as paper C has it, and the successor of a tracklet that it chooses."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.gaps import Bridge, GapMethod, Piece, Surroundings, measured_frames
from trackers.registry import tunable

_P0 = 100.0
_DT = 1.0
"""Time between frames, frames: the unit of time in which 100 I leaves the first velocity and acceleration open."""
NOISE_FILE = "noise.json"
_NOISE = json.loads(resources.files("trackers.gap_kalman").joinpath(NOISE_FILE).read_text())


@dataclass(frozen=True)
class CaKalmanParameters:
    """Noise of the filter; the paper prints neither. The defaults are of maximum likelihood on development swims of
    one slow fish, found by ``python -m tools learn-swims``.

    Attributes:
        jerk_px: square root of the spectral density of the white jerk, px / frame^2.5; gives Q.
        measured_px: standard deviation of a measured coordinate, px; gives R.
    """

    jerk_px: float = tunable(_NOISE["jerk_px"], 1e-5, 10.0, log=True)
    measured_px: float = tunable(_NOISE["measured_px"], 0.01, 10.0, log=True)


class CaKalman:
    """A ``GapMethod`` that only extrapolates.

    State ``x = [x y vx vy ax ay]ᵀ`` in px and frames, at first the first position, velocity and acceleration, and
    ``P = 100 I``. Each frame ``y = z - H x̄, S = H P̄ Hᵀ + R, K = P̄ Hᵀ S⁻¹, x = x̄ + K y, P = (I - K H) P̄``, then
    ``x̄ = F x, P̄ = F P Fᵀ + Q``. Reading: the paper prints neither P̄ nor R, without which the velocity is never
    corrected; Q is that of a white jerk; time is counted in frames, as the paper counts gaps. Frames without a
    measurement are predicted.
    """

    def __init__(self, parameters: CaKalmanParameters) -> None:
        self._parameters = parameters

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learns nothing: the noise is a parameter."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        p = self._parameters
        x, P = first_state(past), _P0 * np.eye(6)
        filter_track(past.position_px[measured_frames(past)[0] :], _DT, p.jerk_px**2, p.measured_px**2, x, P)
        positions, covariances = predict_track(x, P, _DT, p.jerk_px**2, count)
        return Bridge(positions, covariances + p.measured_px**2 * np.eye(2))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> None:
        """Does not use the far end."""


def successor_distances(
    method: GapMethod, past: Piece, candidates: Sequence[Piece], around: Surroundings
) -> NDArray[np.float64]:
    """Return for each candidate the distance (px) of its first position to the one predicted for that frame.

    The as-written linker takes the nearest. Infinite for a candidate that begins before the past ends, or not measured.

    Raises:
        ValueError: for a method that needs both ends.
    """
    gaps = np.array([piece.first_frame + int(measured_frames(piece)[0]) - past.end_frame for piece in candidates], int)
    distances = np.full(len(candidates), np.inf)
    if len(candidates) == 0 or gaps.max() < 0:
        return distances
    bridge = method.extrapolate(past, int(gaps.max()) + 1, around)
    if bridge is None:
        raise ValueError("method: expected one that extrapolates, got one that needs both ends")
    for k, piece in enumerate(candidates):
        if gaps[k] >= 0:
            first_px = piece.position_px[measured_frames(piece)[0]]
            distances[k] = np.hypot(*(first_px - bridge.position_px[gaps[k]]))
    return distances


def first_state(piece: Piece) -> NDArray[np.float64]:
    """Return the state (6,) at the first measured frame, by differences of the three measured ones from it on.

    Velocity and acceleration are zero as far as fewer frames in a row were measured.
    """
    z = piece.position_px[measured_frames(piece)[0] :][:3]
    state = np.zeros(6)
    state[:2] = z[0]
    row = np.isfinite(z.sum(axis=1))
    if len(z) > 1 and row[1]:
        state[2:4] = (z[1] - z[0]) / _DT
        if len(z) > 2 and row[2]:
            state[4:] = (z[2] - 2 * z[1] + z[0]) / _DT**2
    return state


def log_likelihood(piece: Piece, parameters: CaKalmanParameters) -> float:
    """Return the log-likelihood of a track's measurements from its fourth frame on, which the first three predict."""
    x, P = first_state(piece), _P0 * np.eye(6)
    z = piece.position_px[measured_frames(piece)[0] :]
    return filter_track(z, _DT, parameters.jerk_px**2, parameters.measured_px**2, x, P)


@njit(cache=True)
def filter_track(
    z: NDArray[np.float64], dt: float, q: float, r: float, x: NDArray[np.float64], P: NDArray[np.float64]
) -> float:
    """Filter positions z (T, 2), px, NaN where unmeasured; return the log-likelihood of those after the third.

    ``x`` (6,) and ``P`` (6, 6) hold the prediction of the first frame before, and the estimate of the last one after.

    Args:
        dt: time between frames.
        q: spectral density of the jerk, px² over time⁵.
        r: variance of a measured coordinate, px².
    """
    F, Q, H = transition(dt), jerk_noise(dt, q), observation()
    R = r * np.eye(2)
    likelihood = 0.0
    for t in range(z.shape[0]):
        if t > 0:
            x[:] = F @ x
            P[:] = F @ P @ F.T + Q
        if np.isnan(z[t, 0]) or np.isnan(z[t, 1]):
            continue
        y = z[t] - H @ x
        S = H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(S)
        x[:] = x + K @ y
        P[:] = (np.eye(6) - K @ H) @ P
        if t > 2:
            likelihood -= 0.5 * (y @ np.linalg.inv(S) @ y + np.log(np.linalg.det(S))) + np.log(2.0 * np.pi)
    return likelihood


@njit(cache=True)
def predict_track(
    x: NDArray[np.float64], P: NDArray[np.float64], dt: float, q: float, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions (count, 2) and their covariances (count, 2, 2) on the frames after a state; units as above."""
    F, Q, H = transition(dt), jerk_noise(dt, q), observation()
    positions, covariances = np.empty((count, 2)), np.empty((count, 2, 2))
    for t in range(count):
        x = F @ x
        P = F @ P @ F.T + Q
        positions[t] = H @ x
        covariances[t] = H @ P @ H.T
    return positions, covariances


@njit(cache=True)
def transition(dt: float) -> NDArray[np.float64]:
    """Return F (6, 6): ``p + dt v + dt²/2 a, v + dt a, a``."""
    F = np.eye(6)
    for axis in range(2):
        F[axis, axis + 2] = F[axis + 2, axis + 4] = dt
        F[axis, axis + 4] = 0.5 * dt**2
    return F


@njit(cache=True)
def jerk_noise(dt: float, q: float) -> NDArray[np.float64]:
    """Return Q (6, 6) of a white jerk: ``q ∫ g gᵀ dt`` with ``g = (t²/2, t, 1)`` for each axis."""
    Q = np.zeros((6, 6))
    block = q * np.array(
        [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
    )
    for axis in range(2):
        for i in range(3):
            for j in range(3):
                Q[axis + 2 * i, axis + 2 * j] = block[i, j]
    return Q


@njit(cache=True)
def observation() -> NDArray[np.float64]:
    """Return H (2, 6), which picks x and y."""
    H = np.zeros((2, 6))
    H[0, 0] = H[1, 1] = 1.0
    return H
