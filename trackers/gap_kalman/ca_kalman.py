"""``ca_kalman``: the Kalman filter of constant acceleration, and the successor of a tracklet by it (paper C)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.fish_chain.detection import Detector, DetectorParameters
from trackers.fish_chain.fish import Fish, measured
from trackers.fish_chain.tracklets import Tracklet, TrackletBuilder, TrackletParameters
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings, measured_frames
from trackers.registry import register, tunable
from trackers.types import CameraModel, Observation, Track

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


_SEARCH_FRAMES = 200
_LEAST_FRAMES = 5
"""A successor begins within so many frames, and lasts as long at least."""


@register(
    "ca_kalman",
    role="as-written",
    summary="constant-acceleration Kalman filter of paper C; a tracklet goes on in the one nearest to its prediction",
    suites=("fish",),
)
class CaKalmanTracker:
    """Names the tracklets of ``fish_chain`` as the paper does.

    Reading: tracklets get their successors in the order of their ends, each start once. Nothing is answered in gaps,
    nor names at once: until the last picture every tracklet has a name of its own.

    Source: paper C, see ``trackers.papers``.
    """

    Parameters = CaKalmanParameters

    def __init__(self, parameters: CaKalmanParameters, rng: np.random.Generator) -> None:
        self.gap_method = CaKalman(parameters)
        self._begin(())

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._begin(background)

    def _begin(self, background: Sequence[Observation]) -> None:
        self._detector = Detector(DetectorParameters())
        self._detector.start(background)
        self._builder = TrackletBuilder(TrackletParameters(use_posture=False))
        self._times_s: list[float] = []

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        frame = len(self._times_s)
        self._times_s.append(observation.time_s)
        detections = self._detector.detect(observation)
        self._builder.step(frame, detections, self._detector.body_px)
        return [measured(each.number, each.line_px(frame), each.box_xyxy(frame), 1.0) for each in self._builder.active]

    def revised(self) -> list[list[Track]]:
        """See ``RevisingTracker``."""
        tracklets = sorted([*self._builder.ended, *self._builder.active], key=lambda each: each.end_frame)
        fish = {each.number: Fish([each]) for each in tracklets}
        heads = {each.number for each in tracklets}
        for tail in tracklets:
            free = [each for each in tracklets if each.number in heads and self._may_follow(tail, each)]
            if free:
                nearest = free[self._nearest(tail, free)]
                heads.remove(nearest.number)
                fish[nearest.number] = fish[tail.number]
                fish[tail.number].join(Fish([nearest]), 1.0)
        answers: list[list[Track]] = [[] for _ in self._times_s]
        for tracklet in tracklets:
            for frame in range(tracklet.first_frame, tracklet.end_frame):
                name, line, box = fish[tracklet.number].identity, tracklet.line_px(frame), tracklet.box_xyxy(frame)
                answers[frame].append(measured(name, line, box, 1.0))
        return answers

    def _may_follow(self, tail: Tracklet, start: Tracklet) -> bool:
        return 0 <= start.first_frame - tail.end_frame <= _SEARCH_FRAMES and len(start) >= _LEAST_FRAMES

    def _nearest(self, tail: Tracklet, starts: Sequence[Tracklet]) -> int:
        steps_s = np.diff(self._times_s)
        interval_s = max(float(np.median(steps_s)), 1e-3) if len(steps_s) else 1.0
        pieces = [each.piece(interval_s) for each in starts]
        return int(np.argmin(successor_distances(self.gap_method, tail.piece(interval_s), pieces, Surroundings())))
