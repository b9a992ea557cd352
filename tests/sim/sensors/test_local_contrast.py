"""Local contrast: ripples at the gain of detail beside a strong edge that the curve of the gain control shows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.sensors.local_contrast import show_detail
from sim.sensors.thermal_sensor import BIN_COUNTS, BINS

COUNTS_PER_K, GREY_PER_COUNT = 60.0, 0.25
TONE = np.linspace(20.0, 235.0, BINS).astype(np.float32)
ROWS, COLUMNS = np.mgrid[0:144, 0:192].astype(float)


def shown(counts: NDArray[np.float64], grey_per_count: float = GREY_PER_COUNT) -> NDArray[np.float64]:
    grey = np.empty(counts.shape, np.uint8)
    show_detail(np.round(counts).astype(np.uint16), TONE, grey_per_count, COUNTS_PER_K, grey)
    return grey.astype(float)


@pytest.mark.parametrize("level", [0, 3000, 16383])
def test_an_even_picture_is_on_the_curve(level: int) -> None:
    np.testing.assert_allclose(shown(np.full((48, 64), float(level))), TONE[level // BIN_COUNTS], atol=0.5)


@pytest.mark.parametrize("gain", [0.1, 0.25])
def test_a_ripple_has_the_gain_of_detail(gain: float) -> None:
    ripple = 0.8 * COUNTS_PER_K * np.sin(2.0 * np.pi * ROWS / 12.0)
    swing = np.ptp(shown(6000.0 + ripple, gain)[48:96, 48:96]) / np.ptp(ripple)
    assert swing == pytest.approx(gain, rel=0.15)


def test_a_strong_edge_is_where_the_curve_has_it_and_a_ripple_beside_it_is_seen() -> None:
    ripple = 0.5 * COUNTS_PER_K * np.sin(2.0 * np.pi * ROWS / 12.0)
    cold, warm = 5000.0, 5000.0 + 25.0 * COUNTS_PER_K
    grey = shown(np.where(COLUMNS < 96, cold, warm) + ripple)
    for side, level in ((slice(8, 80), cold), (slice(112, 184), warm)):
        assert grey[36:108, side].mean() == pytest.approx(TONE[int(level) // BIN_COUNTS], abs=3.0)
        assert np.ptp(grey[36:108, side].mean(axis=1)) > 0.5 * GREY_PER_COUNT * np.ptp(ripple)
    # Beside it both sides shade off a little, and a rim of two pixels is left, as cameras have it.
    across = grey[36:108].mean(axis=0)
    assert across[:94].min() > across[8:80].mean() - 10.0
    assert across[98:].max() < across[112:184].mean() + 10.0


def test_small_pictures_have_it_too() -> None:
    assert shown(np.full((3, 5), 4000.0)).shape == (3, 5)
