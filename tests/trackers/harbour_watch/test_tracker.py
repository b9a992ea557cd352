"""``harbour_watch`` on a drawn quay."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.harbour_watch.drawn_quay import CAMERA, VIEW, Intruder, Quay
from trackers.registry import entry

PERSON_M = (0.5, 0.5, 1.7)


def watch(seed: int, frames: int, intruders, **changes):
    """Return the answers of every frame; ``intruders(k)`` lists who is there."""
    quay = Quay(seed)
    tracker = entry("harbour_watch").create(np.random.default_rng(0), **changes)
    tracker.start(quay.background(), CAMERA)
    return [tracker.update(quay.later(k, intruders(k))) for k in range(frames)]


def near(track, place_m, within_m=1.5):
    return bool(np.hypot(*(VIEW.place_of(track.estimate) - place_m)[:2]) < within_m)


@pytest.fixture(scope="module")
def stood():
    """A person walks in, stands still for five minutes and walks on."""

    def where(k):
        return (5.0, -8.0 + 1.2 * (min(max(k - 10, 0), 8) + max(k - 168, 0)), 0.0)

    answers = watch(1, 176, lambda k: [Intruder(where(k), PERSON_M, 0.8)] if k >= 10 else [])
    return where, answers


def test_a_person_who_stands_still_for_five_minutes_is_not_swallowed(stood):
    where, answers = stood
    found = [any(t.confidence > 0.9 and near(t, where(k)) for t in answers[k]) for k in range(12, 176)]
    assert np.mean(found) > 0.97
    assert all(found[-6:])


def test_one_person_is_one_track_with_the_size_of_a_person(stood):
    _, answers = stood
    sure = {t.identity for tracks in answers[12:] for t in tracks if t.confidence > 0.9}
    assert len(sure) == 1
    [track] = [t for t in answers[160] if t.confidence > 0.9]
    assert track.kind == "person"
    assert track.size_m[2] == pytest.approx(1.7, abs=0.15)


def test_tide_sun_and_waves_raise_no_alarm():
    answers = watch(2, 150, lambda k: [])
    assert sum(t.confidence > 0.5 for tracks in answers for t in tracks) == 0
