"""How one target is followed from track to track of a tracker of many."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.test_tracks import BOX, Scripted, observation
from trackers.follow_one import FollowOne
from trackers.types import Estimate, Track

RATE_HZ = 15
"""Of ``observation``."""
HALF_PX = np.array([5.0, 5.0])


def seen(identity: int, x: float, y: float = 15.0, confidence: float | None = None, kind: str | None = None) -> Track:
    """Return a track with a box as large as the target's first one."""
    place = np.array([x, y])
    box = np.concatenate([place - HALF_PX, place + HALF_PX])
    return Track(identity, Estimate(place, box_xyxy=box), kind, confidence=confidence)


def followed(answers: Sequence[Sequence[Track]]) -> NDArray[np.float64]:
    """Return the places (F, 2) of one target, from the first picture on."""
    one = FollowOne(Scripted([], *answers))
    one.initialise(observation(), BOX)
    return np.array([one.update(observation(k)).position_px for k in range(1, len(answers) + 1)])


def test_a_new_track_where_the_target_is_expected_goes_on_after_half_a_second() -> None:
    """It walks at 30 px/s; its track ends at x = 45, and another begins a third of a second later."""
    walk = [[seen(1, 15.0 + 2.0 * k)] for k in range(16)]
    places = followed([*walk, [], [], [], [], *([seen(2, 45.0 + 2.0 * k)] for k in range(5, 12))])
    assert np.isfinite(places[:16]).all()
    known = np.isfinite(places[16:]).all(axis=1)
    # Away for longer than half a second on the eighth picture.
    assert known.tolist() == [False] * 7 + [True] * 4
    np.testing.assert_array_equal(places[-1], [67.0, 15.0])


@pytest.mark.parametrize("backwards", [False, True])
def test_of_several_the_nearest_is_taken_in_whatever_order_they_are_told(backwards: bool) -> None:
    late = [seen(5, 20.0), seen(3, 10.0), seen(4, 12.0)]
    [*_, last] = followed([[seen(1, 15.0)], *([[]] * 9), late[::-1] if backwards else late])
    np.testing.assert_array_equal(last, [12.0, 15.0])


def test_of_two_as_near_the_one_known_for_longer_is_taken() -> None:
    [*_, last] = followed([[seen(1, 15.0)], *([[]] * 9), [seen(8, 17.0), seen(7, 13.0)]])
    np.testing.assert_array_equal(last, [13.0, 15.0])


def test_a_fallen_probability_is_an_absence() -> None:
    both = [[seen(1, 15.0, confidence=0.2), seen(2, 18.0, confidence=0.9)]] * 9
    places = followed([[seen(1, 15.0, confidence=0.9)], *both])
    # Meanwhile the answer is that of the unlikely track.
    assert places[:, 0].tolist() == [15.0] * 8 + [18.0] * 2


def test_an_unlikely_track_is_not_taken() -> None:
    places = followed([[seen(1, 15.0)], *([[seen(2, 15.0, confidence=0.4)]] * 30)])
    assert np.isnan(places[1:]).all()


def test_who_was_seen_apart_from_the_target_is_someone_else() -> None:
    places = followed([[seen(1, 15.0), seen(2, 40.0)]] * 3 + [[seen(2, 16.0)]] * 30)
    assert np.isnan(places[3:]).all()


def test_another_kind_is_someone_else() -> None:
    places = followed([[seen(1, 15.0, kind="person")]] * 3 + [[seen(2, 15.0, kind="car")]] * 30)
    assert np.isnan(places[3:]).all()
    for kind in ("person", None):
        places = followed([[seen(1, 15.0, kind="person")]] * 3 + [[seen(2, 15.0, kind=kind)]] * 30)
        np.testing.assert_array_equal(places[-1], [15.0, 15.0])


def test_the_longer_it_is_away_the_farther_it_is_looked_for_but_not_anywhere() -> None:
    """A box of 10 px: 15 px a second, and 60 px at most."""
    places = followed([[seen(1, 15.0)], *([[seen(2, 45.0)]] * 40)])
    taken = int(np.flatnonzero(places[:, 0] == 45.0)[0])
    assert taken == pytest.approx(2.0 * RATE_HZ, abs=1)
    assert np.isnan(followed([[seen(1, 15.0)], *([[]] * 100), [seen(2, 80.0)]])[-1]).all()


def test_the_first_identity_that_is_said_again_is_the_target_again() -> None:
    away: list[list[Track]] = [[]] * 9
    np.testing.assert_array_equal(followed([[seen(1, 15.0)], *away, [seen(1, 60.0)]])[-1], [60.0, 15.0])
    guessed = [[seen(1, 15.0)], *away, [seen(2, 15.0)], *away, [seen(3, 15.0)]]
    np.testing.assert_array_equal(followed(guessed)[-1], [15.0, 15.0])
    for said, place in (([1, 2, 3], 61.0), ([2, 3], 62.0), ([3], 63.0)):
        tracks = [seen(identity, 60.0 + identity) for identity in said]
        np.testing.assert_array_equal(followed([*guessed, tracks, tracks])[-2:], [[place, 15.0]] * 2)
    # Believed if it is likely, and whoever was taken for the target meanwhile is someone else.
    unlikely = [seen(1, 61.0, confidence=0.3), seen(2, 16.0)]
    np.testing.assert_array_equal(followed([[seen(1, 15.0)], *away, [seen(2, 15.0)], unlikely])[-1], [16.0, 15.0])
    back = [[seen(1, 15.0)], *away, [seen(2, 15.0)], [seen(1, 15.0), seen(2, 18.0)]]
    assert np.isnan(followed([*back, *([[seen(2, 16.0)]] * 30)])[-1]).all()


def test_what_stays_where_a_new_track_walks_away_is_not_the_target() -> None:
    leaves = [[seen(1, 15.0), seen(2, 18.0 + k)] for k in range(20)]
    places = followed([[seen(1, 15.0)], *leaves, [seen(1, 15.0), seen(2, 40.0)], [seen(1, 15.0)]])
    assert places[5, 0] == 15.0
    # Though the identity of what was left behind is still said.
    np.testing.assert_array_equal(places[-2], [40.0, 15.0])
    assert np.isnan(places[-1]).all()


def test_a_target_that_walks_on_is_followed_past_one_that_appears_beside_it() -> None:
    places = followed([[seen(1, 15.0)], *([seen(1, 15.0 + k), seen(2, 18.0)] for k in range(40))])
    np.testing.assert_array_equal(places[1:, 0], 15.0 + np.arange(40))


def test_a_target_that_is_found_late_may_have_left_its_first_box() -> None:
    late = followed([*([[]] * 15), [seen(2, 24.0)]])
    np.testing.assert_array_equal(late[-1], [24.0, 15.0])
    # Someone else, who was there before, did not leave it.
    assert np.isnan(followed([[seen(2, 45.0)], *([[seen(2, 24.0)]] * 15)])).all()
    np.testing.assert_array_equal(followed([[seen(2, 45.0)], [seen(2, 19.0)]])[-1], [19.0, 15.0])
