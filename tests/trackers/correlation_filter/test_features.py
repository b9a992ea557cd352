"""Features against a plain NumPy version of the written rule, and what they must and must not notice."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.correlation_filter.features import CELL, CHANNELS, cell_features, gradients


def _plain_gradients(patch_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Felzenszwalb et al. 2010, section 6.1 to 6.3, by whole arrays."""
    padded = np.pad(patch_rgb.astype(float), ((1, 1), (1, 1), (0, 0)), mode="edge")
    dy, dx = padded[2:, 1:-1] - padded[:-2, 1:-1], padded[1:-1, 2:] - padded[1:-1, :-2]
    channel = np.argmax(dx**2 + dy**2, axis=-1)[..., None]
    dx, dy = (np.take_along_axis(each, channel, -1)[..., 0] for each in (dx, dy))
    direction = np.rint(np.arctan2(dy, dx) / (2 * np.pi) * 18).astype(int) % 18
    height, width = patch_rgb.shape[:2]
    rows, columns = height // CELL, width // CELL
    middles_y, middles_x = (CELL * (np.arange(count) + 0.5) - 0.5 for count in (rows, columns))
    share_y = np.maximum(1 - np.abs(np.arange(height)[None] - middles_y[:, None]) / CELL, 0)
    share_x = np.maximum(1 - np.abs(np.arange(width)[None] - middles_x[:, None]) / CELL, 0)
    length = np.hypot(dx, dy)
    sums = np.stack([share_y @ (length * (direction == k)) @ share_x.T for k in range(18)])
    both = sums[:9] + sums[9:]
    energy = np.pad((both**2).sum(0), 1, mode="edge")
    out = np.zeros((31, rows, columns))
    for n in range(4):
        i, j = divmod(n, 2)
        block = sum(energy[i + a : i + a + rows, j + b : j + b + columns] for a in (0, 1) for b in (0, 1))
        scale = 1 / np.sqrt(block + 1)
        cut = np.minimum(sums * scale, 0.2)
        out[:18] += 0.5 * cut
        out[18:27] += 0.5 * np.minimum(both * scale, 0.2)
        out[27 + n] = 0.2357 * cut.sum(0)
    return out


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 7), st.integers(2, 7))
def test_gradients_follow_the_written_rule(seed: int, rows: int, columns: int) -> None:
    patch = np.random.default_rng(seed).integers(0, 256, (CELL * rows, CELL * columns, 3)).astype(np.uint8)
    np.testing.assert_allclose(gradients(patch), _plain_gradients(patch), atol=2e-5)


def test_a_flat_patch_has_no_gradients() -> None:
    features = cell_features(np.full((16, 24, 3), 90, np.uint8))
    assert features.shape == (CHANNELS, 4, 6)
    assert not features[:31].any()
    assert np.isfinite(features).all()


def test_light_does_not_change_gradients_and_colour_does_not_change_with_place() -> None:
    dark = np.random.default_rng(1).integers(0, 120, (32, 32, 3)).astype(np.uint8)
    np.testing.assert_allclose(gradients(dark), gradients(2 * dark + 15), atol=1e-3)


@pytest.mark.parametrize(("rgb", "term"), [((0, 0, 0), 0), ((235, 10, 10), 3), ((5, 5, 250), 8), ((250, 250, 250), 2)])
def test_a_basic_colour_has_the_share_of_its_term(rgb: tuple[int, int, int], term: int) -> None:
    shares = cell_features(np.full((8, 8, 3), rgb, np.uint8))[31:42, 0, 0]
    assert np.argmax(shares) == term
    assert shares.sum() == pytest.approx(0.0, abs=1e-5), "shares sum to 1, and their mean is taken off"
