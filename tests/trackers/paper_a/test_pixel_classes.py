"""Pixel classes and the existence probability against the paper's rules, written out pixel by pixel."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.paper_a.pixel_classes import BUILDING, OTHER, ROAD, classify_pixels, mean_existence

MEAN = np.array([[100.0, 100.0, 100.0], [60.0, 140.0, 60.0]])
VARIANCE = np.array([[400.0, 100.0, 400.0], [900.0, 900.0, 100.0]])


def test_classes_are_the_papers() -> None:
    image = np.random.default_rng(0).integers(30, 180, (40, 50, 3), dtype=np.uint8)
    image[:10] = (100, 104, 95)
    image[10:20] = (70, 130, 62)
    classes = classify_pixels(image, MEAN, VARIANCE)
    distance = ((image[:, :, None] - MEAN) ** 2 / VARIANCE).mean(axis=-1)
    is_road, is_other = distance[..., 0] < 1, distance[..., 1] < 1
    expected = np.where(is_road == is_other, BUILDING, np.where(is_road, ROAD, OTHER))
    np.testing.assert_array_equal(classes, expected)
    assert (classes[:10] == ROAD).all()
    assert (classes[10:20] == OTHER).all()


def test_what_both_classes_claim_is_building() -> None:
    image = np.full((2, 2, 3), 100, np.uint8)
    assert (classify_pixels(image, np.stack([MEAN[0], MEAN[0]]), VARIANCE) == BUILDING).all()


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
