"""The judge of the suite ``harbour`` on small harbours made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.statistics import froc
from tests.benchmarks.judges.harbour.hand_made import judged, of_visits, standing, track, values
from trackers.types import Estimate, Track

FRAMES = 90
HOURS = FRAMES * 2.0 / 3600.0
PERSON = standing("person", (10.0, 3.0), range(20, 40))


def stands(at_m: tuple[float, float], first: int, end: int) -> Callable[[int], list[Track]]:
    """Return the answers of a tracker that has a track there on frames [first, end)."""
    return lambda k: [track(7, at_m)] if first <= k < end else []


def test_what_is_tracked_four_times_running_is_found() -> None:
    for end, found in ((28, 0.0), (29, 1.0)):
        scores = judged([PERSON], FRAMES, stands((10.0, 3.0), 25, end))
        assert of_visits(scores, "found") == {"person-0": found}
        assert of_visits(scores, "found_as_in_paper") == {"person-0": found}
    assert of_visits(scores, "time_to_detect_s") == {"person-0": 2.0 * (25 + 3 - 20)}
    assert of_visits(scores, "chance_rate") == {"person-0": 0.0}
    assert values(scores)["false_alarms_per_hour"] == 0.0


def test_a_pause_or_another_identity_starts_anew() -> None:
    def pauses(k: int) -> list[Track]:
        return [track(7, (10.0, 3.0))] if 20 <= k < 40 and k % 4 else []

    def renames(k: int) -> list[Track]:
        return [track(k // 3, (10.0, 3.0))] if 20 <= k < 40 else []

    for answer in (pauses, renames):
        scores = judged([PERSON], FRAMES, answer)
        assert of_visits(scores, "found") == of_visits(scores, "found_as_in_paper") == {"person-0": 0.0}
        # Right places are no alarms.
        assert values(scores)["false_tracks_per_frame"] == 0.0


@pytest.mark.parametrize(("off_m", "found"), [((2.9, 0.0), 1.0), ((3.1, 0.0), 0.0), ((0.0, 2.9), 0.0)])
def test_on_it_is_within_3_m_and_overlapping(off_m: tuple[float, float], found: float) -> None:
    """Along the line of sight the regions overlap for metres; across it not."""
    place = (10.0 + off_m[0], 3.0 + off_m[1])
    scores = judged([PERSON], FRAMES, lambda k: [track(7, place)] if 20 <= k < 40 else [])
    assert of_visits(scores, "found") == {"person-0": found}
    assert of_visits(scores, "found_as_in_paper") == {"person-0": float(off_m[1] == 0)}
    # Beside it in the world or in the picture is neither right nor wrong.
    assert values(scores)["false_alarms_per_hour"] == 0.0
    errors = of_visits(scores, "position_error_m")
    assert errors == ({"person-0": pytest.approx(2.9)} if found else {})
    beyond = of_visits(scores, "beyond_m")
    assert beyond == ({"person-0": pytest.approx(off_m[0], rel=1e-3)} if off_m[0] else {})


def test_a_duplicate_is_no_alarm_and_finds_nobody_else() -> None:
    two = [PERSON, standing("person", (10.5, 4.5), range(20, 40))]

    def doubles(k: int) -> list[Track]:
        return [track(1, (10.0, 3.0)), track(2, (10.2, 3.0))] if 20 <= k < 40 else []

    scores = judged(two, FRAMES, doubles)
    assert of_visits(scores, "found") == {"person-0": 1.0, "person-1": 0.0}
    assert of_visits(scores, "duplicate_rate") == {"person-0": 1.0}
    assert values(scores)["false_tracks_per_frame"] == 0.0
    # One track between two people finds one of them alone.
    scores = judged(two, FRAMES, lambda k: [track(1, (10.0, 3.4), size_m=(3.0, 3.0, 1.8))] if 20 <= k < 40 else [])
    assert sum(of_visits(scores, "found").values()) == 1.0
    assert sum(of_visits(scores, "found_as_in_paper").values()) == 2.0


def test_a_spare_track_takes_over_where_the_other_is_not_confident() -> None:
    """At a threshold at which the nearer track is gone the other one finds the person."""

    def doubles(k: int) -> list[Track]:
        return [track(1, (10.0, 3.0), confidence=0.3), track(2, (11.0, 3.0), confidence=0.8)] if 20 <= k < 40 else []

    found = np.array(values(judged([PERSON], FRAMES, doubles))["froc_found"])
    assert (found == (froc.THRESHOLDS <= 0.8)).all()


def test_a_swap_of_two_tracks() -> None:
    places = [(10.0, 3.0), (10.0, -3.0)]
    two = [standing("person", at, range(20, 40)) for at in places]

    def swaps(k: int) -> list[Track]:
        names = (1, 2) if k < 30 else (2, 1)
        return [track(name, at) for name, at in zip(names, places, strict=True)] if 20 <= k < 40 else []

    scores = values(judged(two, FRAMES, swaps))
    assert scores["identity_switches"] == 2.0
    assert scores["mota"] == pytest.approx(1.0 - 2 / 40)
    assert (scores["identity_right_frames"], scores["identity_false_frames"]) == (20.0, 20.0)
    assert scores["gospa_m"] == pytest.approx(0.0, abs=1e-9)
    assert scores["hota"] == pytest.approx(np.sqrt(1 / 3), abs=1e-9)


def test_silence_misses_all_and_alarms_nobody() -> None:
    scores = judged([PERSON], FRAMES, lambda k: [])
    assert of_visits(scores, "found") == {"person-0": 0.0}
    assert of_visits(scores, "duplicate_rate") == {}
    told = values(scores)
    assert (told["hota"], told["mota"], told["false_alarms_per_hour"]) == (0.0, 0.0, 0.0)
    # One target missed on 20 of 90 frames costs half the cut-off each.
    assert told["gospa_m"] == pytest.approx(1.5 * 20 / 90)
    nowhere = Track(3, Estimate(np.full(2, np.nan)))
    assert values(judged([PERSON], FRAMES, lambda k: [nowhere])) == told


def test_a_harbour_without_intruders_has_alarms_alone() -> None:
    told = judged([], FRAMES, lambda k: [track(7, (10.0, 3.0))])
    assert not [each for each in told if each.event]
    assert values(told)["false_alarms_per_hour"] == pytest.approx(1 / HOURS)


def test_what_nobody_could_see_is_reported_apart() -> None:
    seen = [4.9, 5.1]
    people = [
        standing("person", (10.0, y), range(20, 40), contrast_to_noise=s) for y, s in zip((3, -3), seen, strict=True)
    ]
    scores = judged(people, FRAMES, lambda k: [])
    assert (of_visits(scores, "found"), of_visits(scores, "found_unseen")) == ({"person-1": 0.0}, {"person-0": 0.0})
    assert set(of_visits(scores, "found_as_in_paper")) == {"person-0", "person-1"}
    assert values(scores)["froc_findable"][0] == 1.0


def test_who_is_outside_or_hidden_is_neither_right_nor_wrong() -> None:
    hidden = standing("person", (10.0, 3.0), range(20, 40), visible=dict.fromkeys(range(20, 40), 0.4))
    outside = standing("car", (50.0, 3.0), range(20, 40))
    brief = standing("person", (0.0, -6.0), range(20, 23))

    def answer(k: int) -> list[Track]:
        on = [track(1, (10.0, 3.0)), track(2, (50.0, 3.0), "car"), track(3, (0.0, -6.0))]
        return [each for each in on if 20 <= k < (23 if each.identity == 3 else 40)]

    scores = judged([hidden, outside, brief], FRAMES, answer)
    assert not [each for each in scores if each.event]
    told = values(scores)
    assert (told["false_alarms_per_hour"], told["false_tracks_per_frame"]) == (0.0, 0.0)
    # The one who is judged for three frames only is no visit, but counts frame by frame.
    assert (told["mota"], told["identity_right_frames"]) == (1.0, 3.0)


def test_alarms_everywhere_find_no_more_than_by_chance() -> None:
    """A tracker that always has a track on every place finds everybody, and as often by chance."""
    places = [(float(x), float(y)) for x in range(4, 18, 2) for y in (1, 2, 3, 4, 5)]
    everywhere = [track(k, at) for k, at in enumerate(places)]
    scores = judged([PERSON], FRAMES, lambda k: everywhere)
    # But for those near the person, whose time on them is short, all lie on nothing at any other time.
    assert of_visits(scores, "chance_rate") == {"person-0": 1.0}
    assert of_visits(scores, "found") == {"person-0": None}
    assert values(scores)["froc_findable"][0] == 0.0
    assert of_visits(scores, "found_as_in_paper") == {"person-0": 1.0}


def test_chance_is_taken_off_as_for_guesses() -> None:
    """A track that stands there a third of the time finds the shifted person in about half of the draws."""
    scores = judged([PERSON], FRAMES, lambda k: [track(1, (10.0, 3.0))] if 50 <= k < 80 else [])
    (chance,) = of_visits(scores, "chance_rate").values()
    # Of 89 shifts 30 + 20 - 7 have four frames in common.
    assert 0.2 < chance < 0.8
    (found,) = (each for each in scores if each.metric == "found")
    assert (found.value, found.weight) == (pytest.approx(-chance / (1 - chance)), pytest.approx(1 - chance))
    told = values(scores)
    assert (told["froc_found"][0], told["froc_findable"][0]) == (pytest.approx(-chance), pytest.approx(1 - chance))


def test_every_episode_has_its_own_shifts() -> None:
    """Episodes of equal length differ in the draws, and the trackers of one do not."""
    rates = []
    for height_m in (1.80, 1.81, 1.82, 1.83, 1.80):
        person = standing("person", (10.0, 3.0), range(20, 40), size_m=(0.4, 0.5, height_m))
        scores = judged([person], FRAMES, lambda k: [track(1, (10.0, 3.0))] if 50 <= k < 80 else [])
        rates += of_visits(scores, "chance_rate").values()
    assert rates[0] == rates[-1]
    assert len(set(rates)) > 2


def test_a_perfect_tracker_has_nothing_by_chance() -> None:
    people = [PERSON, standing("person", (10.0, 3.0), range(60, 80))]
    scores = judged(people, FRAMES, lambda k: [track(k // 50, (10.0, 3.0))] if 20 <= k < 40 or 60 <= k < 80 else [])
    assert of_visits(scores, "found") == {"person-0": 1.0, "person-1": 1.0}
    assert set(of_visits(scores, "chance_rate").values()) == {0.0}
    assert values(scores)["hota"] == pytest.approx(1.0)


def test_a_thousand_tracks() -> None:
    rng = np.random.default_rng(0)
    places = np.stack([rng.uniform(-40, 40, 1000), rng.uniform(-16, 16, 1000)], axis=1)
    many = [track(k, tuple(at), confidence=float(rng.random())) for k, at in enumerate(places)]
    told = values(judged([PERSON], 30, lambda k: many))
    assert told["false_tracks_per_frame"] > 900
    assert told["froc_alarms"][0] == told["false_alarms_per_hour"] * 30 * 2 / 3600
    assert (np.diff(told["froc_alarms"]) <= 0).all()


def test_a_tracker_that_answers_with_unlikely_tracks_is_judged_at_its_own_threshold() -> None:
    def answer(k: int) -> list[Track]:
        false = [track(9, (-30.0, 2.0), confidence=0.2)]
        sure = [track(1, (11.0, 3.0), confidence=0.7)] if 25 <= k < 30 else []
        nearer = [track(2, (10.0, 3.0), confidence=0.3)] if 20 <= k < 40 else []
        return [*false, *sure, *nearer]

    everything, decided = (judged([PERSON], FRAMES, answer, decides_at=at) for at in (0.0, 0.5))
    assert of_visits(everything, "time_to_detect_s") == {"person-0": 2.0 * 3}
    assert of_visits(decided, "time_to_detect_s") == {"person-0": 2.0 * 8}
    assert values(everything)["false_alarms_per_hour"] == pytest.approx(1 / HOURS)
    assert values(decided)["false_alarms_per_hour"] == values(decided)["false_tracks_per_frame"] == 0.0
    # The track that is left is the one track, no duplicate of one that is not answered.
    assert of_visits(everything, "position_error_m") == {"person-0": pytest.approx(0.0, abs=1e-6)}
    assert of_visits(decided, "position_error_m") == {"person-0": pytest.approx(1.0)}
    assert of_visits(everything, "duplicate_rate") == {"person-0": 5 / 20}
    assert of_visits(decided, "duplicate_rate") == {"person-0": 0.0}
    curves = [
        {name: each[name] for name in ("froc_found", "froc_alarms")} for each in map(values, (everything, decided))
    ]
    assert curves[0] == curves[1]
    assert (np.array(curves[0]["froc_found"]) == (froc.THRESHOLDS <= 0.7)).all()
