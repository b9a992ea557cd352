"""Pixel classes and the existence probability against the paper's rules, written out pixel by pixel."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.road_shape.existence import BUILDING, OTHER, ROAD, PixelClassifier, mean_existence

MEAN = np.array([[100.0, 100.0, 100.0], [40.0, 40.0, 44.0], [60.0, 140.0, 60.0]])
VARIANCE = np.array([[400.0, 100.0, 400.0], [64.0, 64.0, 64.0], [900.0, 900.0, 100.0]])
OF_ROAD = np.array([True, True, False])
"""Road in the sun and in the shade, and other ground."""


def test_classes_are_the_papers_in_each_light() -> None:
    image = np.random.default_rng(0).integers(30, 180, (40, 50, 3), dtype=np.uint8)
    image[:10] = (100, 104, 95)
    image[10:20] = (70, 130, 62)
    image[20:25] = (43, 38, 46)
    classes = PixelClassifier(MEAN, VARIANCE, OF_ROAD).classify(image)
    for i in range(40):
        for j in range(50):
            within = [
                sum((float(image[i, j, band]) - MEAN[k, band]) ** 2 / VARIANCE[k, band] for band in range(3)) / 3 < 1
                for k in range(3)
            ]
            is_road, is_other = within[0] or within[1], within[2]
            expected = BUILDING if is_road == is_other else ROAD if is_road else OTHER
            assert classes[i, j] == expected
    assert (classes[:10] == ROAD).all()
    assert (classes[10:20] == OTHER).all()
    assert (classes[20:25] == ROAD).all()
    assert (classes[25:] == BUILDING).mean() > 0.5


def test_what_both_classes_claim_is_building() -> None:
    image = np.full((2, 2, 3), 100, np.uint8)
    same = np.stack([MEAN[0], MEAN[0]])
    assert (PixelClassifier(same, VARIANCE[:2], np.array([True, False])).classify(image) == BUILDING).all()
    assert (PixelClassifier(same, VARIANCE[:2], np.array([True, True])).classify(image) == ROAD).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_existence_is_the_mean_over_corrected_and_extended_pixels(axis: int) -> None:
    rng = np.random.default_rng(axis)
    classes = rng.integers(0, 3, (30, 40)).astype(np.uint8)
    corners = rng.integers(-60, 80, (25, 2))
    start, line, half = -20, 15 + 0.2 * np.arange(80), np.full(80, 6.0)
    got = mean_existence(classes, corners, 9, 5, axis, line, start, half, 3.0)
    for (left, top), mean in zip(corners, got, strict=True):
        values = []
        for y in range(top, top + 5):
            for x in range(left, left + 9):
                kind = classes[np.clip(y, 0, 29), np.clip(x, 0, 39)]
                along, across = (x, y) if axis == 0 else (y, x)
                if start <= along < start + 80:
                    beside = abs(across + 0.5 - line[along - start])
                    if beside < 6 or (beside < 9 and kind == BUILDING):
                        kind = ROAD
                values.append({ROAD: 1.0, OTHER: 0.8, BUILDING: 0.1}[int(kind)])
        assert mean == pytest.approx(np.mean(values))


def test_without_a_road_the_border_goes_on_outside() -> None:
    classes = np.full((10, 10), ROAD, np.uint8)
    classes[:, -1] = BUILDING
    none = np.empty(0)
    far = np.array([[500, 2], [-500, 2]])
    np.testing.assert_allclose(mean_existence(classes, far, 4, 4, 0, none, 0, none, 0.0), [0.1, 1.0])
