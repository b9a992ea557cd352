"""False alarms, their causes, and how many there are at each threshold."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.judges.harbour.alarms import froc_alarms
from benchmarks.statistics import froc
from tests.benchmarks.judges.harbour.hand_made import LAND, judged, standing, track, values
from trackers.types import Track

FRAMES = 90
HOURS = FRAMES * 2.0 / 3600.0
PERSON = standing("person", (10.0, 3.0), range(20, 40))


def test_an_alarm_is_an_identity_on_nothing_four_times_running() -> None:
    def alarms(k: int) -> list[Track]:
        short = [track(1, (-30.0, 2.0), confidence=0.9)] if k % 4 else []
        return short + ([track(2, (-30.0, -2.0), confidence=0.2 + 0.05 * (k == 50))] if k < 80 else [])

    told = values(judged([], FRAMES, alarms))
    assert told["false_alarms_per_hour"] == pytest.approx(1 / HOURS)
    assert told["false_tracks_per_frame"] == pytest.approx((FRAMES - 23 + 80) / FRAMES)
    # Four frames running of 0.2: one of 0.25 is not enough for a higher threshold.
    assert (np.array(told["froc_alarms"]) == (froc.THRESHOLDS <= 0.2)).all()


@pytest.mark.parametrize(("back", "alarms"), [(40, 1), (41, 2)])
def test_an_identity_that_comes_back_after_a_minute_is_another_alarm(back: int, alarms: int) -> None:
    there = {*range(5, 11), *range(back, back + 5)}
    told = values(judged([], FRAMES, lambda k: [track(1, (-30.0, 2.0))] if k in there else []))
    assert told["false_alarms_per_hour"] == pytest.approx(alarms / HOURS)
    assert told["froc_alarms"][0] == alarms


def falling_short(k: int) -> list[Track]:
    """Return one track on nothing whose confidence is low for longer than a minute."""
    return [track(1, (-30.0, 2.0), confidence=0.2 if 20 <= k < 60 else 0.9)]


def test_the_pause_between_alarms_is_one_of_sure_tracks() -> None:
    told = np.array(values(judged([], FRAMES, falling_short))["froc_alarms"])
    assert told.tolist() == np.select([froc.THRESHOLDS <= 0.2, froc.THRESHOLDS <= 0.9], [1.0, 2.0]).tolist()


@pytest.mark.heavy
@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, len(froc.THRESHOLDS) - 1))
def test_alarms_at_a_threshold_are_those_of_a_tracker_that_decides_there(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    confidence = rng.choice([0.1, 0.4, 0.5, 0.9], (3, 6)).repeat(15, axis=1) * rng.choice([0.9, 1.0], (3, FRAMES))
    silent = rng.random((3, FRAMES)) < 0.05

    def flickers(frame: int) -> list[Track]:
        places = ((-30.0, 2.0), (-30.0, -2.0), (10.0, 3.0))
        return [
            track(n, at, confidence=float(confidence[n, frame])) for n, at in enumerate(places) if not silent[n, frame]
        ]

    threshold = float(froc.THRESHOLDS[k])
    curve = values(judged([PERSON], FRAMES, flickers))["froc_alarms"]
    decided = values(judged([PERSON], FRAMES, flickers, decides_at=threshold))
    assert curve[k] == pytest.approx(decided["false_alarms_per_hour"] * HOURS)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_alarms_over_thresholds_are_those_counted_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frame, identity = np.nonzero(rng.random((80, 4)) < 0.9)
    confidence = rng.choice(froc.THRESHOLDS, 6)[rng.integers(0, 6, (20, 4)).repeat(4, axis=0)[frame, identity]]
    pause = int(rng.integers(1, 12))
    expected = []
    for threshold in froc.THRESHOLDS:
        count = 0
        for name in range(4):
            on = frame[(identity == name) & (confidence >= threshold)].tolist()
            for part in np.split(on, np.flatnonzero(np.diff(on) > pause) + 1):
                there = set(part.tolist())
                count += any({k, k + 1, k + 2, k + 3} <= there for k in there)
        expected.append(float(count))
    (score,) = froc_alarms(frame, identity, confidence, float(pause))
    assert score.value == expected


def test_alarms_of_a_hundred_thousand_tracks_are_counted_in_a_moment() -> None:
    rng = np.random.default_rng(0)
    frame = np.repeat(np.arange(2100), 50)
    began_s = time.thread_time()
    (score,) = froc_alarms(frame, np.tile(np.arange(50), 2100), rng.random(len(frame)), 30.0)
    assert time.thread_time() - began_s < 2.0
    assert len(score.value) == len(froc.THRESHOLDS)


def test_a_ghost_of_who_has_left_is_an_alarm() -> None:
    def stays(k: int) -> list[Track]:
        return [track(1, (10.0, 3.0))] if 20 <= k < 44 else []

    assert values(judged([PERSON], FRAMES, stays))["false_alarms_per_hour"] == pytest.approx(1 / HOURS)
    leaves = judged([PERSON], FRAMES, lambda k: stays(k) if k < 43 else [])
    assert values(leaves)["false_alarms_per_hour"] == 0.0


@pytest.mark.parametrize(
    ("at_m", "steps", "cause"),
    [
        ((-30.0, 2.0), (), "wave"),
        ((10.0, 18.0), (), "tide"),
        ((10.0, -16.0), (), "bird"),
        ((10.0, 18.0), (30,), "agc_step"),
        ((10.0, 18.0), (29,), "agc_step"),
        ((10.0, 18.0), (28, 31, 32, 33), "tide"),
    ],
)
def test_alarms_have_causes(at_m: tuple[float, float], steps: tuple[int, ...], cause: str) -> None:
    told = values(judged([], FRAMES, lambda k: [track(5, at_m)] if k >= 30 else [], steps=steps))
    counts = {name: value * HOURS for name, value in told.items() if name.startswith("false_alarms_per_hour_")}
    assert {name: value for name, value in counts.items() if value} == {
        f"false_alarms_per_hour_{cause}": pytest.approx(1.0)
    }


def test_on_land_it_is_shadow_and_beside_the_picture_something_else() -> None:
    for place, cause in (((10.0, -2.0), "shadow"), ((10.0, -60.0), "other")):
        told = values(judged([], FRAMES, lambda k, at=place: [track(7, at)], clutter=LAND))
        assert told[f"false_alarms_per_hour_{cause}"] == pytest.approx(1 / HOURS)
