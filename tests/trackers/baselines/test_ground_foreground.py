"""MOG2, KNN and the median before a hand-drawn harbour."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW, DrawnHarbour, checked_answers
from trackers.baselines.ground_foreground import median_and_noise
from trackers.registry import entry
from trackers.types import Track

NAMES = ("harbour_mog2", "harbour_knn", "harbour_median")
WALK = [np.array([4.0 - 0.5 * k, 3.0 - 0.7 * k]) for k in range(12)]
QUIET = 5


def answers(name: str, harbour: DrawnHarbour) -> list[Sequence[Track]]:
    # As written: tuned values are for the scene that they were tuned on.
    tracker = entry(name).create(np.random.default_rng(0), **entry(name).written())
    tracker.survey(SURVEY)
    tracker.start(harbour.pictures(80), CAMERA)
    pictures = [*harbour.pictures(QUIET), *(harbour.picture([place_m]) for place_m in WALK)]
    return checked_answers(tracker, pictures)


@pytest.mark.parametrize("name", NAMES)
def test_a_person_who_walks_is_found_and_followed(name: str) -> None:
    made = answers(name, DrawnHarbour(0))
    assert made[:QUIET] == [[]] * QUIET
    for place_m, tracks in zip(WALK[3:], made[QUIET + 3 :], strict=True):
        [track] = tracks
        assert track.identity == made[QUIET + 3][0].identity
        assert np.hypot(*(VIEW.place_of(track.estimate)[:2] - place_m)) < 1.2
        assert track.size_m is not None
        np.testing.assert_allclose(track.size_m, [0.5, 0.5, 1.7], atol=0.3)


def test_the_same_pictures_give_the_same_answers_though_opencv_draws_numbers_of_its_own() -> None:
    first = answers("harbour_knn", DrawnHarbour(1))
    cv2.randu(np.zeros((3, 3), np.uint8), 0, 255)
    again = answers("harbour_knn", DrawnHarbour(1))
    for one, two in zip(first, again, strict=True):
        assert [(each.identity, each.confidence) for each in one] == [(each.identity, each.confidence) for each in two]


@pytest.mark.parametrize("count", [1, 4, 7, 60])
def test_median_and_noise_are_those_of_numpy(count: int) -> None:
    samples = np.random.default_rng(count).normal(0, 10, (9, 11, count)).astype(np.float32)
    middle, noise = median_and_noise(samples, 1.5)
    ordered = np.sort(samples, axis=-1)
    np.testing.assert_array_equal(middle, ordered[..., count // 2])
    away = np.sort(np.abs(samples - ordered[..., count // 2][..., None]), axis=-1)[..., count // 2]
    np.testing.assert_allclose(noise, np.maximum(1.4826 * away, 1.5), rtol=1e-6)


def test_the_median_is_renewed_and_a_short_stay_does_not_enter_it() -> None:
    harbour, tracker = (
        DrawnHarbour(2),
        entry("harbour_median").create(np.random.default_rng(0), samples=20, renew_pictures=3),
    )
    tracker.survey(SURVEY)
    tracker.start(harbour.pictures(40), CAMERA)
    stands = np.array([0.0, 0.0])
    found = [bool(tracker.update(harbour.picture([stands]))) for _ in range(60)]
    assert sum(found[3:20]) > 14
    # Once more than half of the 20 samples show it, it is background.
    assert not any(found[45:])
