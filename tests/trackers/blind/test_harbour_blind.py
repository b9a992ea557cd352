"""``harbour_blind`` sees nothing and alarms now and then, ``harbour_posts`` all the time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW, DrawnHarbour, checked_answers
from trackers.blind.harbour_blind import HarbourBlind
from trackers.registry import entry
from trackers.site import place
from trackers.types import Observation, Track

# By the survey of the camera that it was learnt with the volume lies up to a metre away.
VOLUME = place(replace(SURVEY, watched_m=(92.0, 34.0, 6.0)), CAMERA, VIEW.T_world_camera)
FRAMES = 900


def answers(shown: list[Observation], name: str = "harbour_blind", **changes: float) -> list[Sequence[Track]]:
    tracker: HarbourBlind = entry(name).create(np.random.default_rng(3), **changes)
    tracker.survey(SURVEY)
    tracker.start((), CAMERA)
    return checked_answers(tracker, shown)


def without_pictures(count: int) -> list[Observation]:
    drawn = DrawnHarbour(0).picture()
    empty = np.empty((0, 0, 3), np.uint8)
    return [replace(drawn, image_rgb=empty, time_s=2.0 * k) for k in range(count)]


def test_alarms_come_as_often_as_they_should_and_last() -> None:
    made = answers(without_pictures(FRAMES), alarms_per_hour=200.0, pictures=10)
    identities, pictures = np.unique([track.identity for tracks in made for track in tracks], return_counts=True)
    expected = 200.0 * FRAMES * 2.0 / 3600.0
    # Poisson: within five standard deviations.
    assert abs(len(identities) - expected) < 5 * np.sqrt(expected)
    assert (pictures[:-10] == 10).all()


@pytest.mark.heavy
def test_alarms_lie_inside_the_watched_volume_and_stay_where_they_are() -> None:
    made = answers(without_pictures(FRAMES))
    places_m = {}
    for tracks in made:
        for track in tracks:
            place_m = places_m.setdefault(track.identity, VIEW.place_of(track.estimate))
            np.testing.assert_allclose(VIEW.place_of(track.estimate), place_m)
    assert VOLUME.contains(np.array(list(places_m.values()))).all()


def test_posts_stand_at_the_most_visited_places_from_first_to_last() -> None:
    made = answers(without_pictures(3), "harbour_posts", posts=4)
    confidences = [[track.confidence for track in tracks] for tracks in made]
    assert confidences == [sorted(confidences[0], reverse=True)] * 3
    assert confidences[0][0] == 1.0
    assert len({track.identity for tracks in made for track in tracks}) == len(confidences[0]) == 4
    every = answers(without_pictures(1), "harbour_posts", posts=60)[0]
    assert sorted((each.confidence for each in every), reverse=True)[:4] == confidences[0]


@pytest.mark.parametrize("name", ["harbour_blind", "harbour_posts"])
def test_it_does_not_look_at_pictures(name: str) -> None:
    blank = without_pictures(60)
    drawn = [
        replace(each, image_rgb=picture.image_rgb)
        for each, picture in zip(blank, DrawnHarbour(5).pictures(60), strict=True)
    ]
    for one, two in zip(answers(blank, name), answers(drawn, name), strict=True):
        assert [(each.identity, each.confidence) for each in one] == [(each.identity, each.confidence) for each in two]
