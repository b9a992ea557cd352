"""When a parked car has left its place."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from trackers.harbour_watch.watch import Parked, shows_background_behind

NOISE = np.full((40, 60), 2.0, np.float32)
CAR = SimpleNamespace(identity=3, seen_px=np.array([20.2, 10.0, 35.6, 19.7]))


def shown(car_counts: float, at_column: int = 20):
    left = np.random.default_rng(0).normal(0.0, 2.0, NOISE.shape).astype(np.float32)
    left[10:20, at_column : at_column + 16] += car_counts
    return left


@pytest.fixture
def parked() -> Parked:
    places = Parked()
    places.look([CAR], shown(80.0))
    return places


def test_a_car_that_cools_stays(parked):
    for k in range(100):
        left = shown(80.0 * 0.98**k)
        assert not list(parked.left(left, NOISE))
        parked.look([CAR], left)


def test_a_place_is_left_once_most_of_it_shows_something_else_and_for_six_pictures(parked):
    assert not list(parked.left(shown(80.0, at_column=25), NOISE))
    found = [list(parked.left(shown(80.0, at_column=25 + 6 * k), NOISE)) for k in range(1, 9)]
    assert [len(each) for each in found] == [1] * 6 + [0] * 2
    # Whole pixels about the region, with a rim of four.
    assert found[0] == [(16, 6, 40, 24)]


@pytest.mark.parametrize("counts", [80.0, -30.0])
def test_the_background_shows_what_has_left_and_the_picture_what_has_come(counts):
    empty, taken = shown(0.0), shown(counts)
    assert shows_background_behind(empty, taken, NOISE, CAR.seen_px)
    assert not shows_background_behind(taken, empty, NOISE, CAR.seen_px)


def test_a_car_that_is_seen_to_have_cooled_has_not_left():
    """It stood there before the start, and is found when it differs from what the background shows of it."""
    assert not shows_background_behind(shown(60.0), shown(70.0), NOISE, CAR.seen_px)


def test_noise_is_no_edge():
    """Without it the picture of an empty place would have as many edges as a faint car in the background."""
    rng = np.random.default_rng(1)
    noisy = rng.normal(0.0, 8.0, NOISE.shape).astype(np.float32)
    faint = np.zeros_like(noisy)
    faint[10:20, 20:36] = 12.0
    assert shows_background_behind(noisy, faint, np.full_like(NOISE, 8.0), CAR.seen_px)
