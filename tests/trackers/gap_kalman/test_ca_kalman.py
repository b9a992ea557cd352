"""The filter of constant acceleration against batch least squares, and the successor that it chooses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from trackers.gap_kalman.ca_kalman import (
    CaKalman,
    CaKalmanParameters,
    first_state,
    jerk_noise,
    log_likelihood,
    successor_distances,
    transition,
)
from trackers.gaps import Piece, Surroundings, check_bridge

DT = 1.0
PARAMETERS = CaKalmanParameters(jerk_px=0.05, measured_px=0.5)


def swim(frames: int, seed: int = 0) -> Piece:
    rng = np.random.default_rng(seed)
    x = np.cumsum(np.cumsum(rng.normal(0, 0.1, (frames, 2)), axis=0), axis=0)
    return Piece(7, x + 100.0, DT)


def batch(piece: Piece, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return mean (T, 6) and covariance of all states together: one least-squares problem, without recursion.

    Its residuals are those of the first state, of every ``x[t] - F x[t - 1]`` and of every measurement, over their
    standard deviations.
    """
    T = len(piece.position_px) + count
    F, step = transition(DT), np.linalg.inv(np.linalg.cholesky(jerk_noise(DT, PARAMETERS.jerk_px**2)))
    rows, wanted = [np.eye(6, 6 * T) / 10.0], [first_state(piece) / 10.0]
    for t in range(1, T):
        row = np.zeros((6, 6 * T))
        row[:, 6 * t - 6 : 6 * t], row[:, 6 * t : 6 * t + 6] = -step @ F, step
        rows.append(row)
        wanted.append(np.zeros(6))
    for t in np.flatnonzero(np.isfinite(piece.position_px).all(axis=1)):
        rows.append(np.eye(2, 6 * T, 6 * t) / PARAMETERS.measured_px)
        wanted.append(piece.position_px[t] / PARAMETERS.measured_px)
    inverse = np.linalg.pinv(np.concatenate(rows), rcond=1e-15)
    return (inverse @ np.concatenate(wanted)).reshape(T, 6), inverse @ inverse.T


def joint_covariance(frames: int) -> np.ndarray:
    """Return the covariance (2 T, 2 T) of the measurements of frames in a row, before any is known."""
    F, Q = transition(DT), jerk_noise(DT, PARAMETERS.jerk_px**2)
    S = PARAMETERS.measured_px**2 * np.eye(2 * frames)
    P = 100.0 * np.eye(6)
    for t in range(frames):
        for later in range(t, frames):
            block = (np.linalg.matrix_power(F, later - t) @ P)[:2, :2]
            S[2 * later : 2 * later + 2, 2 * t : 2 * t + 2] += block
            if later > t:
                S[2 * t : 2 * t + 2, 2 * later : 2 * later + 2] += block.T
        P = F @ P @ F.T + Q
    return S


@pytest.mark.parametrize("lost", [(), (4, 5, 9)])
def test_the_prediction_is_that_of_batch_least_squares(lost: tuple[int, ...]) -> None:
    piece = swim(20)
    piece.position_px[list(lost)] = np.nan
    bridge = CaKalman(PARAMETERS).extrapolate(piece, 5, Surroundings())
    mean, covariance = batch(piece, 5)
    np.testing.assert_allclose(bridge.position_px, mean[20:, :2], rtol=1e-6)
    for k in range(5):
        at = 6 * (20 + k) + np.array([0, 1])
        wanted = covariance[np.ix_(at, at)] + PARAMETERS.measured_px**2 * np.eye(2)
        np.testing.assert_allclose(bridge.covariance_px[k], wanted, rtol=1e-5, atol=1e-9)


def test_the_likelihood_is_that_of_the_joint_gaussian() -> None:
    piece = swim(12)

    def joint(frames: int) -> float:
        part = Piece(0, piece.position_px[:frames], DT)
        S = joint_covariance(frames)
        F, state = transition(DT), first_state(piece)
        mean = [(np.linalg.matrix_power(F, t) @ state)[:2] for t in range(frames)]
        return float(multivariate_normal(np.ravel(mean), S).logpdf(part.position_px.ravel()))

    assert log_likelihood(piece, PARAMETERS) == pytest.approx(joint(12) - joint(3), rel=1e-6)


@given(st.lists(st.floats(-50, 50), min_size=6, max_size=6))
def test_a_parabola_is_continued(numbers: list[float]) -> None:
    start, velocity, acceleration = np.reshape(numbers, (3, 2)) * [[1.0], [0.1], [0.001]]
    t = DT * np.arange(160.0)[:, None]
    x = start + velocity * t + 0.5 * acceleration * t**2
    bridge = CaKalman(CaKalmanParameters()).extrapolate(Piece(0, x[:60], DT), 100, Surroundings())
    # By differences the first velocity is that of half a frame later; the filter corrects it.
    np.testing.assert_allclose(bridge.position_px, x[60:], atol=0.05 * (1 + np.abs(acceleration).max()))


@settings(max_examples=25)
@given(st.integers(1, 12), st.integers(1, 40), st.sets(st.integers(0, 11)))
def test_every_past_with_one_measurement_is_answered(frames: int, count: int, lost: set[int]) -> None:
    piece = swim(frames)
    piece.position_px[[k for k in lost if k < frames - 1]] = np.nan
    check_bridge(CaKalman(PARAMETERS).extrapolate(piece, count, Surroundings()), count)


def test_a_past_without_measurement_is_refused() -> None:
    with pytest.raises(ValueError, match="position_px: expected at least one measured position, got none"):
        CaKalman(PARAMETERS).extrapolate(Piece(0, np.full((3, 2), np.nan), DT), 2, Surroundings())


def test_the_successor_is_the_piece_that_begins_where_the_filter_predicts() -> None:
    t = np.arange(100.0)[:, None]
    way = np.hstack([2.0 * t, 50.0 + 0 * t])
    past = Piece(0, way[:60], DT)
    candidates = [
        Piece(80, way[80:], DT),
        Piece(80, way[80:] + np.array([0.0, 30.0]), DT),
        Piece(40, way[40:], DT),
        Piece(70, np.vstack([np.full((3, 2), np.nan), way[73:]]), DT),
    ]
    distances = successor_distances(CaKalman(PARAMETERS), past, candidates, Surroundings())
    np.testing.assert_allclose(distances, [0.0, 30.0, np.inf, 0.0], atol=1e-3)
    assert successor_distances(CaKalman(PARAMETERS), past, [], Surroundings()).shape == (0,)
