"""The edges of a region to a fraction of a pixel."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from trackers.harbour_watch.detection import refined


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
