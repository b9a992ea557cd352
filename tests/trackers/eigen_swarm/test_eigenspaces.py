"""Eigenspaces of blocks beside an independent PCA, block by block."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from trackers.eigen_swarm.eigenspaces import BlockEigenspaces, learn, likelihood

CONTRIBUTION = 0.95


def pictures(count: int, seed: int = 0, shape: tuple[int, int] = (12, 20)) -> list[NDArray[np.uint8]]:
    """Return pictures whose light changes, one half more than the other, with noise."""
    rng = np.random.default_rng(seed)
    still = rng.uniform(60, 190, shape)
    half = np.arange(shape[1]) < shape[1] // 2
    made = [
        still + rng.normal(0, 10) + half * rng.normal(0, 6) + rng.normal(0, 3.0, shape) * (0.3 + half)
        for _ in range(count)
    ]
    return [np.clip(np.round(each), 0, 255).astype(np.uint8) for each in made]


def cut(grey: NDArray[np.uint8], row: int, column: int) -> NDArray[np.float64]:
    """Return a block (64,) of the enlarged picture, cut by hand."""
    large = cv2.resize(grey, (2 * grey.shape[1], 2 * grey.shape[0]), interpolation=cv2.INTER_LINEAR)
    return large[8 * row : 8 * row + 8, 8 * column : 8 * column + 8].astype(float).ravel()


def by_svd(greys: list[NDArray[np.uint8]], grey: NDArray[np.uint8], row: int, column: int) -> tuple[float, int]:
    """Return r_D of a block, and D, by a singular value decomposition."""
    X = np.stack([cut(each, row, column) for each in greys])
    _, singular, axes = np.linalg.svd(X - X.mean(axis=0), full_matrices=False)
    eigenvalues = singular**2 / (len(greys) - 1)
    D = int(np.searchsorted(np.cumsum(eigenvalues) / eigenvalues.sum(), CONTRIBUTION)) + 1
    s = axes[:D] @ (cut(grey, row, column) - X.mean(axis=0))
    return float((s**2 / eigenvalues[:D]).mean()), D


@pytest.fixture(scope="module")
def learnt() -> BlockEigenspaces:
    return learn(pictures(150), CONTRIBUTION)


def test_it_is_the_pca_of_each_block(learnt: BlockEigenspaces) -> None:
    other = pictures(151)[-1].copy()
    other[4:8, 12:16] += 30
    r = learnt.relative_variation(other)
    assert r.shape == (3, 5)
    expected = [[by_svd(pictures(150), other, row, column) for column in range(5)] for row in range(3)]
    np.testing.assert_allclose(r, [[each[0] for each in row] for row in expected], rtol=2e-3)
    np.testing.assert_array_equal(learnt.dimensions.reshape(3, 5), [[each[1] for each in row] for row in expected])
    assert len(set(learnt.dimensions)) > 1
    assert r[1, 3] > 5.0 * np.delete(r.ravel(), [7, 8, 9]).max()


def test_relative_variations_of_the_training_pictures_have_the_mean_one(learnt: BlockEigenspaces) -> None:
    greys = pictures(150)
    r = np.array([learnt.relative_variation(each) for each in greys])
    # The sum of s² over the training pictures is (N - 1) times the eigenvalue, whatever the distribution.
    np.testing.assert_allclose(r.mean(axis=0), 149 / 150, rtol=1e-3)


def test_relative_variations_of_new_pictures_are_chi_square(learnt: BlockEigenspaces) -> None:
    many = learn(pictures(2000), CONTRIBUTION)
    r = np.array([many.relative_variation(each) for each in pictures(2600)[2000:]])
    D = many.dimensions.reshape(3, 5)
    # Mean 1, variance 2 / D, if the values of a block are normal.
    np.testing.assert_allclose(r.mean(axis=0), 1.0, atol=0.25)
    np.testing.assert_allclose(r.var(axis=0) * D / 2.0, 1.0, atol=0.6)


def test_a_block_that_never_changes_does_not_divide_by_zero() -> None:
    still = np.full((12, 20), 90, np.uint8)
    spaces = learn([still, still, still], CONTRIBUTION)
    assert (spaces.relative_variation(still) == 0.0).all()
    assert np.isfinite(spaces.relative_variation(still + 9)).all()


def test_what_is_too_small_for_a_block_has_none() -> None:
    spaces = learn([np.zeros((2, 3), np.uint8)] * 2, CONTRIBUTION)
    assert spaces.relative_variation(np.zeros((2, 3), np.uint8)).shape == (0, 0)


def test_the_sigmoid_is_a_half_at_its_threshold_and_never_overflows() -> None:
    r, D = np.array([15.0, 9.0, 14.0, 1e9]), np.array([20, 21, 20, 5])
    f = likelihood(r, D, gain=0.6, threshold_few=15.0, threshold_many=9.0, few=20)
    np.testing.assert_allclose(f, [0.5, 0.5, 1 / (1 + np.exp(0.6)), 1.0])


@pytest.mark.parametrize(
    ("greys", "contribution", "message"),
    [
        ([np.zeros((8, 8), np.uint8)], 0.9, "greys: expected two pictures or more of one size, got 1 of 1 sizes"),
        ([np.zeros((8, 8), np.uint8), np.zeros((8, 9), np.uint8)], 0.9, "got 2 of 2 sizes"),
        ([np.zeros((8, 8), np.uint8)] * 2, 0.0, r"contribution: expected a share in \(0, 1\], got 0.0"),
    ],
)
def test_what_cannot_be_learnt_is_refused(greys: list[NDArray[np.uint8]], contribution: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        learn(greys, contribution)
