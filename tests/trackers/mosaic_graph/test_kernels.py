"""Kernels of our tracker against plain arithmetic and other libraries."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize

from trackers.kernels.particles import detection_log_weights, geometric_median
from trackers.mosaic_graph.colour_model import CELLS, count_colours, look_up
from trackers.mosaic_graph.kernels import oriented_box as ob
from trackers.mosaic_graph.kernels.skeleton import thin, trace_lines
from trackers.mosaic_graph.mosaic import blend_into


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_geometric_median_is_the_minimum_of_the_expected_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, weights = rng.normal(0, 5, (40, 2)), rng.random(40)

    def cost(m: np.ndarray) -> float:
        return float(weights @ np.linalg.norm(points - m, axis=1))

    best = optimize.minimize(cost, weights @ points / weights.sum(), method="Nelder-Mead", options={"xatol": 1e-6})
    assert cost(geometric_median(points, weights, 60)) <= best.fun * (1 + 1e-3)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_detection_weights_are_the_formula(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, h, p = rng.normal(0, 2, (7, 2)), rng.uniform(-3, 3, 7), rng.random(7) * 0.9
    z, a, log_ratio = rng.normal(0, 2, (3, 2)), np.array([0.3, np.nan, -1.0]), rng.normal(0, 2, 3)
    deviations = np.array([0.7, 0.4, 1.2])
    got = detection_log_weights(x, h, p, True, z, a, log_ratio, deviations, 0.3)
    for i in range(7):
        fit = log_ratio - 0.5 * ((z - x[i]) ** 2).sum(axis=1) / deviations**2
        sharp = 0.1 + 0.9 * np.sqrt(np.pi / 2) / 0.3 * np.exp(-0.5 * np.sin(a - h[i]) ** 2 / 0.09)
        fit += np.where(np.isnan(a), 0.0, np.log(sharp))
        assert got[i] == pytest.approx(np.log(1 - p[i] + p[i] * np.exp(fit.max())))


def test_the_likelihood_ratio_of_an_axis_has_the_mean_one() -> None:
    """The mean over uniform headings, against an axis of unknown direction."""
    headings = np.linspace(-np.pi, np.pi, 2001)[:-1]
    at, ones = np.zeros((2000, 2)), np.ones(2000)
    args = (at, headings, ones, True, np.zeros((1, 2)), np.array([0.4]), np.zeros(1), np.ones(1))
    assert np.exp(detection_log_weights(*args, 0.12)).mean() == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(np.exp(detection_log_weights(*args, 100.0)), 1.0, atol=0.001)


def test_a_miss_counts_only_where_the_target_is_detectable() -> None:
    x, nothing = np.zeros((2, 2)), np.empty((0, 2))
    args = (x, np.zeros(2), np.array([0.0, 0.6]))
    missed = detection_log_weights(*args, True, nothing, np.empty(0), np.empty(0), np.empty(0), 0.3)
    np.testing.assert_allclose(missed, [0.0, np.log(0.4)], atol=1e-12)
    ignored = detection_log_weights(*args, False, nothing, np.empty(0), np.empty(0), np.empty(0), 0.3)
    np.testing.assert_allclose(ignored, 0.0, atol=1e-12)


def test_blending_is_the_mean_until_the_slowest_rate() -> None:
    rng = np.random.default_rng(3)
    pictures = rng.integers(0, 256, (5, 4, 6, 3)).astype(np.uint8)
    mean, rounded, count = np.zeros((4, 6, 3), np.float32), np.zeros((4, 6, 3), np.uint8), np.zeros((4, 6), np.uint8)
    for picture in pictures:
        blend_into(mean, rounded, count, picture, np.full((4, 6), 255, np.uint8), 0.01)
    np.testing.assert_allclose(mean, pictures.mean(axis=0), atol=1e-3)
    np.testing.assert_allclose(rounded, mean, atol=0.51)
    assert (count == 5).all()


def test_unseen_cells_are_left_alone_and_doubtful_ones_do_not_count() -> None:
    mean, rounded, count = np.zeros((1, 2, 3), np.float32), np.zeros((1, 2, 3), np.uint8), np.zeros((1, 2), np.uint8)
    for _ in range(3):
        patch = np.full((1, 2, 3), 90, np.uint8)
        blend_into(mean, rounded, count, patch, np.array([[0, 1]], np.uint8), 0.1)
    assert count.tolist() == [[0, 1]]
    assert mean[0, 0].sum() == 0
    assert (rounded[0, 1] == 90).all()


def test_colour_table_counts_and_looks_up_the_same_cell() -> None:
    rng = np.random.default_rng(4)
    rgb = rng.integers(0, 256, (9, 7, 3)).astype(np.uint8)
    counts = np.zeros(CELLS, np.float32)
    count_colours(counts, rgb, np.ones((9, 7), np.float32), 1)
    cell = (rgb.astype(int) >> 3) @ np.array([1024, 32, 1])
    np.testing.assert_array_equal(counts, np.bincount(cell.ravel(), minlength=CELLS))
    np.testing.assert_array_equal(look_up(counts, rgb), counts[cell])


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_thinning_keeps_pieces_together_and_leaves_no_block(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mask = np.zeros((60, 60), np.uint8)
    for _ in range(4):
        ends = rng.integers(8, 52, (2, 2)).tolist()
        cv2.line(mask, ends[0], ends[1], 1, int(rng.integers(3, 8)))
    skeleton = thin(mask)
    assert (skeleton <= mask).all()
    assert cv2.connectedComponents(skeleton)[0] == cv2.connectedComponents(mask)[0]
    assert skeleton.sum() < 0.5 * mask.sum()


def test_tracing_a_cross_gives_its_four_arms() -> None:
    skeleton = np.zeros((21, 21), np.uint8)
    skeleton[10, 2:19] = 1
    skeleton[2:19, 10] = 1
    cells, offsets = trace_lines(skeleton)
    long = [cells[a:b] for a, b in pairwise(offsets) if b - a > 4]
    assert len(long) == 4
    assert {tuple(c) for c in cells} == set(zip(*np.nonzero(skeleton), strict=True))


def test_tracing_a_ring_goes_round_once() -> None:
    skeleton = np.zeros((30, 30), np.uint8)
    cv2.circle(skeleton, (15, 15), 9, 1, 1)
    cells, offsets = trace_lines(thin(skeleton))
    assert len(offsets) == 2
    assert len(cells) >= 40


@settings(max_examples=15, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-3, 3), st.floats(-3, 3))
def test_a_drawn_box_is_found_where_it_lies(angle: float, d_x: float, d_y: float) -> None:
    centre, half = np.array([40.0 + d_x, 30.0 + d_y]), np.array([11.0, 4.5])
    c, s = np.cos(angle), np.sin(angle)
    corners = centre + np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * half @ np.array([[c, s], [-s, c]])
    mask = np.zeros((60, 80), np.uint8)
    cv2.fillConvexPoly(mask, np.round(corners * 16).astype(np.int32), 1, shift=4)
    log_ratio = np.where(mask > 0, 3.0, -3.0).astype(np.float32)
    unknown = np.full((60, 80), ob.UNKNOWN, np.uint8)
    spot, axis = ob.spot_axis(log_ratio, unknown, np.array([40.0, 30.0]), 14.0, 0.03)
    assert np.linalg.norm(spot - centre) < 1.0
    assert abs(np.sin(axis - angle)) < 0.1
    place, heading, measures = ob.fit_box(
        np.zeros((60, 80, 3), np.uint8),
        log_ratio,
        unknown,
        np.zeros((ob.ALONG, ob.ACROSS, 3), np.float32),
        spot,
        np.eye(2),
        half,
        axis + np.array([-0.2, 0.0, 0.2]),
        2,
        np.array([1.0, -0.7, 0, 0, 0, 0, 0]),
    )
    assert np.linalg.norm(place - centre) < 1.5
    assert abs(np.sin(heading - angle)) < 0.2
    assert measures[ob.INSIDE] > 2.3
    assert measures[ob.KNOWN] == 0.0


def test_a_template_matches_itself_either_way_round() -> None:
    rng = np.random.default_rng(5)
    rgb = cv2.GaussianBlur(rng.integers(0, 256, (60, 80, 3)).astype(np.uint8), (9, 9), 3)
    centre, along, across = np.array([40.0, 30.0]), np.array([11.0, 0.0]), np.array([0.0, 4.5])
    template = ob.sample_template(rgb, centre, along, across)
    flat, unknown = np.zeros((60, 80), np.float32), np.full((60, 80), ob.UNKNOWN, np.uint8)
    for sign in (1.0, -1.0):
        measures = ob.measure_box(rgb, flat, unknown, template, centre, sign * along, sign * across)
        assert measures[ob.MISMATCH] < 6.0
    elsewhere = ob.measure_box(rgb, flat, unknown, template, centre + 9, along, across)
    assert elsewhere[ob.MISMATCH] > 2 * measures[ob.MISMATCH]
