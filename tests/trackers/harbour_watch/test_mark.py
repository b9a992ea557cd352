"""The rectangle of a box beside projections by hand, its derivatives, and headings."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.harbour_watch.drawn_quay import VIEW
from trackers.harbour_watch.mark import Heading, linearised, rectangles
from trackers.harbour_watch.sightings import CAR, KINDS, log_likelihoods


def state(x, y, size_m):
    return np.array([x, y, 0.0, 0.0, *np.log(size_m)])


def test_a_box_covers_its_projected_corners():
    [found] = rectangles(state(4.0, 3.0, (4.0, 1.8, 1.5))[None], 0.0, 0.0, (1.0, 1.0), VIEW)
    estimate = VIEW.estimate_of(np.array([4.0, 3.0, 0.75]), np.array([4.0, 1.8, 1.5]), 0.0)
    np.testing.assert_allclose(found, estimate.box_xyxy, atol=1e-9)


def test_a_small_roof_is_seen_lower():
    box = state(4.0, 3.0, (4.0, 1.8, 1.5))[None]
    [cube], [car] = (rectangles(box, 0.0, 0.0, roof, VIEW) for roof in ((1.0, 1.0), CAR.roof))
    assert car[1] > cube[1] + 1.0
    assert car[3] == cube[3]


def test_the_derivatives_predict_small_changes():
    rng = np.random.default_rng(0)
    for _ in range(20):
        here = state(rng.uniform(-10, 40), rng.uniform(-12, 12), rng.uniform(0.5, 4.0, 3))
        heading = rng.uniform(0.0, np.pi)
        box, jacobian = linearised(here, heading, 0.0, (0.5, 0.8), VIEW)
        step = rng.normal(0.0, 0.003, 7)
        [moved] = rectangles((here + step)[None], heading, 0.0, (0.5, 0.8), VIEW)
        np.testing.assert_allclose(moved, box + jacobian @ step, atol=0.06)


@pytest.mark.parametrize("true_rad", [0.1, 0.25 * np.pi, 0.5 * np.pi])
def test_a_heading_is_told_by_the_direction_of_travel(true_rad):
    heading = Heading()
    for _ in range(5):
        heading.turn()
        heading.travel(2.0 * np.array([np.cos(true_rad), np.sin(true_rad)]), 0.02 * np.eye(2))
    off = (heading.likeliest_rad - true_rad + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    assert abs(off) < 0.15


def test_a_parked_car_is_seen_from_ahead_or_from_the_side():
    covariance = np.diag([1.0, 1.0, 0.1, 0.1, *CAR.spread**2])
    here = state(10.0, 0.0, CAR.size_m)
    for true_rad in (0.0, 0.5 * np.pi):
        heading = Heading()
        [box] = rectangles(here[None], true_rad, 0.0, CAR.roof, VIEW)
        for _ in range(8):
            heading.look(box, here, covariance, 0.0, CAR.roof, VIEW)
        off = (heading.likeliest_rad - true_rad + 0.5 * np.pi) % np.pi - 0.5 * np.pi
        assert abs(off) < 0.2


@pytest.mark.parametrize(
    ("width_m", "height_m", "afloat", "name"),
    [
        (0.5, 1.75, False, "person"),
        (4.0, 1.7, False, "car"),
        (1.8, 2.1, False, "car"),
        (6.0, 2.0, True, "boat"),
        (0.3, 0.3, False, "bird"),
        (0.4, 0.3, True, "bird"),
    ],
)
def test_classes_are_told_by_width_and_height(width_m, height_m, afloat, name):
    assert KINDS[int(log_likelihoods(width_m, height_m, afloat, 0.2).argmax())].name == name


def test_from_above_a_car_is_seen_higher_by_its_depth():
    # 4 m wide: its other extent adds to its height by the sine of the slope.
    flat, steep = (log_likelihoods(4.0, 3.2, False, from_above)[KINDS.index(CAR)] for from_above in (0.05, 0.6))
    assert steep > flat + 1.0
