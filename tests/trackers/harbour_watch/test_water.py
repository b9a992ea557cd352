"""Water and its level on a drawn quay."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.harbour_watch.drawn_quay import SURVEY, VIEW, Quay
from trackers.harbour_watch.water import WaterLevel
from trackers.site import shows_water

MEAN_M = SURVEY.mean_water_m


@pytest.fixture(scope="module")
def site():
    quay = Quay(5, wave_k=0.1)
    pictures = np.array([each.counts for each in quay.background(60)], np.float32)
    return quay, pictures


def test_the_level_follows_the_tide(site):
    quay, pictures = site
    water = shows_water(SURVEY, VIEW)
    level = WaterLevel(VIEW, water, np.full(pictures.shape[1:], 8.0, np.float32), MEAN_M)
    # The tides of ``background`` are too fast for a path through them: these are sorted, and their mean is the same.
    tides = 0.8 * np.sin(0.9 * np.arange(60))
    level.settle(pictures[np.argsort(tides)])
    for tide_m in (-0.6, 0.0, 0.7):
        picture = None
        for k in range(60):
            picture = quay.picture(2.0 * k, tide_m=tide_m, sun=0.4).counts.astype(np.float32)
            found = level.of(picture)
        assert found == pytest.approx(MEAN_M + tide_m, abs=0.25)


def test_without_a_wall_there_is_no_level():
    level = WaterLevel(VIEW, np.zeros((192, 256), bool), np.ones((192, 256), np.float32), MEAN_M)
    level.settle(np.zeros((30, 192, 256), np.float32))
    assert level.of(np.zeros((192, 256), np.float32)) is None
