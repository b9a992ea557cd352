"""Centre lines of drawn shapes, and geodesic distances against a library's shortest paths."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import lil_matrix
from scipy.sparse.csgraph import dijkstra

from trackers.fish_chain.posture import STATIONS, geodesic, headings, posture


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
