"""Bodies fitted to blobs: shapes that were drawn are found again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.fish_chain.posture import STATIONS, body_line, fit_bodies, pose_of

HALVES = np.array([1.5, 3.0, 3.5, 3.4, 3.0, 2.4, 1.8, 1.2, 0.8])
DEVIATIONS = np.array([2.5, 2.5, 0.25, 0.25])


def drawn(poses: NDArray[np.float64], length_px: float = 36.0) -> NDArray[np.uint8]:
    """Return a mask with bodies drawn by discs along their lines."""
    mask = np.zeros((90, 90), np.uint8)
    rows, columns = np.indices(mask.shape) + 0.5
    for pose in poses:
        line = body_line(pose, length_px, 65)
        for point, half in zip(line, np.interp(np.linspace(0, 8, 65), np.arange(9), HALVES), strict=True):
            mask |= (np.hypot(columns - point[0], rows - point[1]) <= half).astype(np.uint8)
    return mask


@given(
    st.floats(-100, 100), st.floats(-np.pi, np.pi), st.floats(-1.5, 1.5), st.floats(5, 60), st.sampled_from([3, 9, 17])
)
@settings(deadline=None)
def test_a_line_has_its_length_and_its_pose(
    x: float, direction: float, bend: float, length: float, points: int
) -> None:
    pose = np.array([x, 2 * x, direction, bend])
    line = body_line(pose, length, points)
    steps = np.diff(line, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(length)
    found = pose_of(line)
    np.testing.assert_allclose(found[:2], pose[:2])
    assert np.cos(found[2] - direction) == pytest.approx(1.0)
    assert found[3] == pytest.approx(bend, abs=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_two_bodies_that_cross_are_found_apart(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = np.array([[45.0, 45.0, 0.3, 0.2], [46.0, 41.0, 0.3 + rng.uniform(0.8, 2.3), -0.3]])
    expected = truth + rng.normal(0, 0.8, truth.shape) * DEVIATIONS
    before = np.linalg.norm(expected[:, :2] - truth[:, :2], axis=1)
    found, wrong = fit_bodies(
        drawn(truth), expected, np.full(2, 36.0), np.tile(HALVES, (2, 1)), np.tile(DEVIATIONS, (2, 1)), 1.0
    )
    after = np.linalg.norm(found[:, :2] - truth[:, :2], axis=1)
    assert after.max() < 2.0
    assert after.sum() < before.sum()
    assert wrong < 0.2 * np.count_nonzero(drawn(truth))


def test_the_misfit_is_counted_in_pixels() -> None:
    pose = np.array([[45.0, 45.0, 0.0, 0.0]])
    mask = drawn(pose)
    lines = np.full(1, 36.0), HALVES[None], np.full((1, 4), 1e-6)
    _, right = fit_bodies(mask, pose, *lines, 1.0)
    mask[80:84, 80:85] = 1
    _, more = fit_bodies(mask, pose, *lines, 1.0)
    assert more == right + 20
    assert len(HALVES) == STATIONS
