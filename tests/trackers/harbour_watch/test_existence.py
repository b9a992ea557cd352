"""Scores of objects against those of the background."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.harbour_watch.detection import Region
from trackers.harbour_watch.existence import Clutter, clutter_rates

SHAPE = (96, 128)


def region(x, y, width, height, score):
    return Region(np.array([x - width / 2, y - height, x + width / 2, y], float), score, 1, 10)


@pytest.fixture(scope="module")
def clutter():
    """Weak false regions on the left; a boat that swings about (100, 80), drawn as strong ones."""
    rng = np.random.default_rng(0)
    moving = np.zeros(SHAPE, np.float32)
    moving[50:90, 75:128] = 0.5
    pictures = [
        [region(rng.uniform(0, 40), rng.uniform(20, 90), 4, 9, 4.5 + rng.exponential(0.8)) for _ in range(3)]
        + [region(100 + rng.normal(0, 5), 80 + rng.normal(0, 2), 30, 12, 25.0)]
        for _ in range(60)
    ]
    return Clutter(clutter_rates(SHAPE, 4.5, pictures, moving), 4.5)


def test_a_strong_region_is_likelier_an_object_than_a_weak_one(clutter):
    ratios = [clutter.log_ratio(region(60, 40, 4, 12, score)) for score in (4.6, 6.0, 9.0, 20.0)]
    assert (np.diff(ratios) > 0).all()


def test_where_false_regions_were_frequent_a_weak_one_says_less(clutter):
    assert clutter.log_ratio(region(20, 50, 4, 12, 5.0)) < clutter.log_ratio(region(80, 30, 4, 12, 5.0)) - 1.0


def test_a_moored_boat_speaks_against_an_intruder_and_a_person_before_it_for_one(clutter):
    assert clutter.most_log_odds(region(103, 81, 28, 11, 25.0)) < -1.0
    assert clutter.most_log_odds(region(100, 80, 5, 13, 25.0)) > 1.0
    assert clutter.most_log_odds(region(30, 60, 28, 11, 25.0)) > 3.0


def test_the_rate_of_false_regions_follows_the_episode(clutter):
    there = region(90, 30, 4, 9, 5.0)
    before = clutter.log_ratio(there)
    for _ in range(200):
        clutter.learn([there], np.zeros(SHAPE, np.uint8))
    after = clutter.log_ratio(there)
    for _ in range(200):
        clutter.learn([there], np.ones(SHAPE, np.uint8))
    assert after < before - 1.0
    assert clutter.log_ratio(there) > after
