"""HS histograms against OpenCV's, one rectangle at a time."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from trackers.kernels.histogram import (
    BINS,
    HUE_BINS,
    SATURATION_BINS,
    bhattacharyya,
    hs_bins,
    rectangle_histogram,
    rectangle_similarities,
)


@pytest.fixture(scope="module")
def picture() -> NDArray[np.uint8]:
    noise = np.random.default_rng(0).integers(0, 256, (90, 120, 3), dtype=np.uint8)
    return cv2.GaussianBlur(noise, (7, 7), 0)


def opencv_histogram(image_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
    hsv = cv2.cvtColor(image_rgb, cv2.COLOR_RGB2HSV)
    counts = cv2.calcHist([hsv], [0, 1], None, [HUE_BINS, SATURATION_BINS], [0, 180, 0, 256])
    return counts.ravel().astype(float) / counts.sum()


def test_similarities_are_those_of_opencv_one_by_one(picture: NDArray[np.uint8]) -> None:
    rng = np.random.default_rng(1)
    size = np.array([21.0, 12.0])
    centres = rng.uniform(-15, 130, (400, 2))
    template = opencv_histogram(picture[30:42, 40:61])
    similarities = rectangle_similarities(hs_bins(picture), centres, size, template, 0.123)
    for centre, similarity in zip(centres, similarities, strict=True):
        left, top = np.floor(centre - size / 2 + 0.5).astype(int)
        part = picture[max(top, 0) : max(top + 12, 0), max(left, 0) : max(left + 21, 0)]
        expected = bhattacharyya(template, opencv_histogram(part)) if part.size else 0.123
        assert similarity == pytest.approx(expected, abs=1e-6)


def test_the_template_is_like_itself(picture: NDArray[np.uint8]) -> None:
    centre, size = np.array([50.5, 40.0]), np.array([21.0, 12.0])
    template = rectangle_histogram(hs_bins(picture), centre, size)
    np.testing.assert_allclose(template, opencv_histogram(picture[34:46, 40:61]), atol=1e-7)
    similarity = rectangle_similarities(hs_bins(picture), centre[None], size, template, 0.0)
    assert similarity[0] == pytest.approx(1.0, abs=1e-9)


def test_nothing_visible_is_the_outside_case(picture: NDArray[np.uint8]) -> None:
    far = np.array([[np.nan, 3.0], [-1e9, 5.0], [1e12, 5.0], [60.0, -6.0], [60.0, 96.0]])
    template = np.full(BINS, 1 / BINS)
    assert (rectangle_similarities(hs_bins(picture), far, np.array([21.0, 12.0]), template, 0.4) == 0.4).all()
    assert rectangle_histogram(hs_bins(picture), far[3], np.array([21.0, 12.0])).sum() == 0.0


def test_every_hue_and_saturation_falls_into_opencvs_bin() -> None:
    hue, saturation = np.meshgrid(np.arange(180), np.arange(0, 256, 5))
    hsv = np.stack([hue, saturation, np.full_like(hue, 255)], axis=-1).astype(np.uint8)
    rgb = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)
    counts = np.bincount(hs_bins(rgb).ravel(), minlength=BINS)
    np.testing.assert_allclose(counts / counts.sum(), opencv_histogram(rgb), atol=1e-7)


def test_each_rectangle_is_answered_as_if_it_were_alone(picture: NDArray[np.uint8]) -> None:
    bins, size = hs_bins(picture), np.array([7.0, 5.0])
    template = rectangle_histogram(bins, np.array([20.0, 20.0]), size)
    rng = np.random.default_rng(4)
    for spread_px in (2.0, 30.0, 3000.0):
        centres = np.array([[20.0, 20.0]]) + rng.normal(0.0, spread_px, (60, 2))
        centres[::17] = np.nan
        each = [rectangle_similarities(bins, centre[None], size, template, 0.25)[0] for centre in centres]
        np.testing.assert_array_equal(rectangle_similarities(bins, centres, size, template, 0.25), each)
