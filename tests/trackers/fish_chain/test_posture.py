"""Posture: centre lines of one body and of several in one outline."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse import lil_matrix
from scipy.sparse.csgraph import dijkstra

from trackers.fish_chain.posture import STATIONS, body_line, fit_bodies, geodesic, headings, pose_of, posture


@given(st.integers(0, 10_000), st.integers(1, 9), st.integers(1, 9))
@settings(max_examples=25, deadline=None)
def test_geodesic_distances_are_the_shortest_paths(seed: int, height: int, width: int) -> None:
    rng = np.random.default_rng(seed)
    mask = (rng.random((height, width)) < 0.7).astype(np.uint8)
    mask[0, 0] = 1
    graph = lil_matrix((mask.size, mask.size))
    for i, j in np.argwhere(mask):
        for k, m in np.argwhere(mask):
            if 0 < max(abs(i - k), abs(j - m)) <= 1:
                graph[i * width + j, k * width + m] = np.hypot(i - k, j - m)
    expected = dijkstra(graph.tocsr(), indices=0).reshape(mask.shape)
    np.testing.assert_allclose(geodesic(mask, 0, 0), np.where(mask, expected, np.inf), rtol=1e-5)


@pytest.mark.parametrize("angle", np.linspace(-np.pi, np.pi, 7))
@pytest.mark.parametrize("bend", [0.0, 0.8, 2.2])
def test_the_line_of_a_drawn_body_is_found_head_first(angle: float, bend: float) -> None:
    along = np.linspace(-1, 1, 41)
    direction = angle - 0.5 * bend * along
    line = np.cumsum(np.stack([np.cos(direction), np.sin(direction)], axis=1), axis=0) * -1.0
    line += 40.0 - line[20]
    grey = np.zeros((80, 80), np.uint8)
    for point, share in zip(line, np.linspace(0, 1, 41), strict=True):
        radius = 4.0 * np.sqrt(share * 4 + 0.1) if share < 0.2 else 4.0 * (1.25 - share)
        cv2.circle(grey, np.round((point - 0.5) * 16).astype(int).tolist(), round(16 * radius), 1, -1, cv2.LINE_8, 4)
    body, centre = posture(grey, grey.astype(np.float32), grey.astype(np.float32), STATIONS)
    np.testing.assert_allclose(body[4, :2], line[20], atol=1.7)
    towards = headings(body[None, :, :2])[0] - headings(line[None])[0]
    assert np.cos(towards) > 0.97
    assert body[2, 2] > 1.5 * body[7, 2]
    # The drawn shape's own centre of area, by how wide it is along its line.
    share = np.linspace(0, 1, 41)
    halves = np.where(share < 0.2, np.sqrt(share * 4 + 0.1), 1.25 - share)
    assert centre == pytest.approx(np.average(share, weights=halves), abs=0.03)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 2), (1, 30), (7, 7)])
def test_blobs_without_a_direction_are_no_error(shape: tuple[int, int]) -> None:
    body, _ = posture(np.ones(shape, np.uint8), np.ones(shape, np.float32), np.ones(shape, np.float32), STATIONS)
    assert np.isfinite(body).all()
    np.testing.assert_allclose(body[4, :2], [shape[1] / 2, shape[0] / 2], atol=1.0)


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
