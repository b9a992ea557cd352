"""Detection: edges of regions, the matched filter over boxes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from trackers.harbour_watch.detection import CELL_PX, BoxFilters, refined


def body(x0, y0, x1, y1, sign=1.0):
    """Draw a body with edges between pixels, by supersampling, seen through optics, with noise of one deviation."""
    fine = np.zeros((480, 640), np.float32)
    fine[round(y0 * 8) : round(y1 * 8), round(x0 * 8) : round(x1 * 8)] = sign * 15.0
    seen = cv2.GaussianBlur(cv2.resize(fine, (80, 60), interpolation=cv2.INTER_AREA), (0, 0), 0.6)
    return seen + np.random.default_rng(0).normal(size=seen.shape).astype(np.float32)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5, 0.75])
def test_edges_are_found_within_a_pixel_however_the_body_lies(shift, sign):
    """A sharp body is found half a pixel larger at each side: the share is that of bodies that fade at their ends."""
    true = np.array([30.0 + shift, 20.0 + shift, 36.5 + shift, 33.5 + shift])
    found = refined(body(*true, sign), np.round(np.add(true, (-1.0, -1.0, 2.0, 1.0))))
    outside = (found - true) * [-1.0, -1.0, 1.0, 1.0]
    np.testing.assert_allclose(outside, 0.4, atol=0.4)


def test_a_region_without_a_body_stays_as_it_is():
    box = np.array([10.0, 10.0, 16.0, 20.0])
    np.testing.assert_array_equal(refined(np.zeros((40, 40), np.float32), box), box)


def test_a_narrow_cool_cabin_is_part_of_a_hot_car():
    """The car's bonnet blurs into the rows above it and below."""
    seen = body(20.0, 26.0, 46.0, 34.0, 4.0)
    seen[18:26, 34:44] += 4.0
    found = refined(seen, np.array([20.0, 19.0, 46.0, 35.0]))
    np.testing.assert_allclose(found, [20.0, 18.0, 46.0, 34.0], atol=0.8)


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
