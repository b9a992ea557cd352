"""The matched filter beside a sum by hand, and the noise that it learns."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.harbour_watch.detection import CELL_PX, BoxFilters

SIZES_M = np.array([[0.5, 0.5], [1.0, 2.0]])


@pytest.fixture
def filters():
    return BoxFilters(SIZES_M, np.linspace(4.0, 8.0, 40), 48)


def test_each_box_is_the_sum_over_the_root_of_its_area(filters):
    deviation = np.random.default_rng(0).normal(0.0, 3.0, (40, 48)).astype(np.float32)
    found = filters.filtered(deviation, 4.0)
    clipped = np.clip(deviation.astype(float), -4.0, 4.0)
    for k, i, j in [(0, 20, 20), (1, 30, 5), (1, 3, 40), (0, 39, 47), (1, 39, 0), (0, 0, 0)]:
        half, tall = filters.half_px[k, i], filters.tall_px[k, i]
        part = clipped[max(0, i + 1 - tall) : i + 1, max(0, j - half) : j + half + 1]
        assert found[k, i, j] == pytest.approx(part.sum() / np.sqrt(part.size), abs=1e-3)


def test_boxes_grow_towards_the_camera(filters):
    assert filters.tall_px[1, 39] == 16
    assert filters.tall_px[1, 0] == 8
    assert (np.diff(filters.half_px, axis=1) >= 0).all()


def test_waves_make_a_place_as_quiet_as_others(filters):
    """Neighbouring pixels that err alike make box sums larger than independent ones do; learning takes that out."""
    rng, nobody = np.random.default_rng(1), np.zeros((40, 48), np.uint8)
    for _ in range(300):
        deviation = rng.normal(size=(40, 48)).astype(np.float32)
        deviation[24:] = np.repeat(np.repeat(rng.normal(size=(4, 12)), 4, axis=0), 4, axis=1)
        scaled = filters.scaled(filters.filtered(deviation, 6.0))
        filters.learn(scaled, nobody, 0.05)
    assert filters.variance[1, 4].mean() > 4.0
    assert filters.variance[1, 1].mean() < 1.5
    assert np.std(scaled[1, 26:]) == pytest.approx(1.0, abs=0.35)


def test_claimed_places_are_not_learnt(filters):
    claimed = np.zeros((40, 48), np.uint8)
    claimed[: 2 * CELL_PX] = 1
    filters.learn(np.full((2, 40, 48), 3.0, np.float32), claimed, 0.5)
    assert (filters.variance[:, :2] == 1.0).all()
    assert (filters.variance[:, 2:] == 5.0).all()
