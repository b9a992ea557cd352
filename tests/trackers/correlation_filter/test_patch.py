"""Patches against NumPy's slices and block means."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.correlation_filter.patch import patch_around


def _noise(rows: int, columns: int) -> NDArray[np.uint8]:
    return np.random.default_rng(0).integers(0, 256, (rows, columns, 3)).astype(np.uint8)


def test_a_patch_at_the_picture_s_own_samples_is_a_part_of_it() -> None:
    image_rgb = _noise(40, 60)
    patch = patch_around(image_rgb, np.array([22.0, 17.0]), np.ones(2), (8, 12))
    np.testing.assert_array_equal(patch, image_rgb[13:21, 16:28])


def test_a_coarser_sample_is_the_mean_of_its_pixels() -> None:
    image_rgb = _noise(48, 60)
    patch = patch_around(image_rgb, np.array([30.0, 24.0]), np.array([3.0, 3.0]), (8, 10))
    blocks = image_rgb[12:36, 15:45].reshape(8, 3, 10, 3, 3).mean((1, 3))
    assert np.abs(patch - blocks).max() <= 1.0


def test_beyond_the_border_the_nearest_pixel_is_repeated() -> None:
    image_rgb = _noise(10, 12)
    patch = patch_around(image_rgb, np.array([0.0, 10.0]), np.ones(2), (20, 20))
    padded = np.pad(image_rgb, ((10, 10), (10, 10), (0, 0)), mode="edge")
    np.testing.assert_array_equal(patch, padded[10:30, 0:20])


def test_sides_may_have_steps_of_their_own() -> None:
    image_rgb = np.broadcast_to(np.arange(0, 240, 4, dtype=np.uint8)[None, :, None], (40, 60, 3)).copy()
    patch = patch_around(image_rgb, np.array([30.0, 20.0]), np.array([0.5, 1.0]), (4, 9))
    np.testing.assert_array_equal(patch[0, :, 0], np.rint(4 * (30 - 0.5 + 0.5 * np.arange(-4, 5))))
