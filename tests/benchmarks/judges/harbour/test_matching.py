"""Matches, runs and chance beside what is counted one by one."""

from __future__ import annotations

import itertools
from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.judges.harbour.answers import Answers, Objects, answers_of, objects_of
from benchmarks.judges.harbour.found import DRAWS, chance_levels
from benchmarks.judges.harbour.matching import RADIUS_M, Answered, Matcher, history_of, match_frame
from benchmarks.judges.harbour.streaks import RUNNING, streaks
from sim.optics import project
from tests.benchmarks.judges.harbour.hand_made import CAMERA, POSE, Intruder, standing, track, truth_of
from trackers.types import Estimate, Track

SEEDS = st.integers(0, 2**32 - 1)


def crowd(rng: np.random.Generator, targets: int, tracks: int) -> tuple[Objects, Answers]:
    """Return people and tracks on a few square metres, so that many lie on several."""
    places = rng.uniform(-4, 4, (targets + tracks, 2))
    people = [standing("person", tuple(at), range(1), size_m=(3.0, 3.0, 2.0)) for at in places[:targets]]
    said = [track(k + 5, tuple(at), size_m=(3.0, 3.0, 2.0)) for k, at in enumerate(places[targets:])]
    return objects_of(truth_of(people, 0)), answers_of(said, CAMERA, POSE)


def boxes_meet(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3])


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(0, 4), st.integers(0, 4))
def test_the_pairing_is_the_best_of_all(seed: int, targets: int, tracks: int) -> None:
    objects, answers = crowd(np.random.default_rng(seed), targets, tracks)
    found = match_frame(objects, answers, np.full(targets, -1))
    away = np.linalg.norm(answers.place_m[:, None, :2] - objects.place_m[None, :, :2], axis=2)
    may = np.array(
        [
            [away[m, n] <= RADIUS_M and boxes_meet(answers.box_xyxy[m], objects.box_xyxy[n]) for n in range(targets)]
            for m in range(tracks)
        ]
    ).reshape(tracks, targets)
    best = 0.0
    for chosen in itertools.product([None, *range(targets)], repeat=tracks):
        taken = [n for n in chosen if n is not None]
        pairs = [(m, n) for m, n in enumerate(chosen) if n is not None]
        if len(taken) == len(set(taken)) and all(may[pair] for pair in pairs):
            best = max(best, sum(2.0 - away[pair] / RADIUS_M for pair in pairs))
    rows = np.flatnonzero(found.first)
    assert sum(2.0 - away[m, found.target[m]] / RADIUS_M for m in rows) == pytest.approx(best)
    assert len(set(found.target[rows].tolist())) == len(rows)
    for m in range(tracks):
        # A duplicate lies on the nearest that it may lie on, and on one that has its one track.
        on = np.flatnonzero(may[m])
        assert (found.target[m] >= 0) == (len(on) > 0)
        if len(on) and not found.first[m]:
            assert found.target[m] == on[away[m, on].argmin()]
            assert found.target[m] in found.target[rows]


def test_an_intruder_keeps_the_track_that_it_had() -> None:
    objects = objects_of(truth_of([standing("person", (10.0, 3.0), range(1))], 0))
    answers = answers_of([track(1, (10.0, 3.0)), track(2, (12.0, 3.0))], CAMERA, POSE)
    assert match_frame(objects, answers, np.array([-1])).first.tolist() == [True, False]
    assert match_frame(objects, answers, np.array([2])).first.tolist() == [False, True]
    matcher = Matcher()
    matcher.match(objects, answers.only(np.array([False, True])))
    matcher.match(objects, answers.only(np.array([False, False])))
    assert matcher.match(objects, answers).first.tolist() == [False, True]


def test_places_are_taken_through_the_true_camera() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform((-40, -16, -2), (45, 16, 3), (20, 3))
    px, depth_m = project(CAMERA, POSE, places)
    said = [Track(k, Estimate(px[k], depth_m=float(depth_m[k]))) for k in range(20)]
    assert answers_of(said, CAMERA, POSE).place_m == pytest.approx(places)
    flat = answers_of([Track(0, Estimate(px[0]))], CAMERA, POSE)
    assert np.isnan(flat.place_m).all()
    assert flat.box_xyxy[0] == pytest.approx([*px[0], *px[0]])
    assert flat.confidence.tolist() == [1.0]


@pytest.mark.parametrize(
    ("box", "excused"),
    [
        # A box of the whole picture is at nobody but for its point.
        ((0.0, 0.0, 384.0, 288.0), False),
        ((170.0, 120.0, 182.0, 140.0), True),
        ((150.0, 120.0, 158.0, 140.0), False),
    ],
)
def test_at_an_intruder_in_the_picture_is_not_a_whole_picture(box: tuple[float, ...], excused: bool) -> None:
    objects = objects_of(truth_of([standing("person", (10.0, 2.2), range(1))], 0))
    assert objects.box_xyxy[0] == pytest.approx([175.0, 118.0, 178.6, 130.7], abs=0.1)
    far = Track(1, Estimate(np.array([60.0, 200.0]), np.array(box), depth_m=90.0))
    matches = match_frame(objects, answers_of([far], CAMERA, POSE), np.array([-1]))
    assert (matches.excused.tolist(), matches.false.tolist()) == ([excused], [not excused])


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_runs_are_those_counted_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    there = rng.random((3, 25)) < 0.8
    key, frame = np.nonzero(there)
    value = rng.integers(0, 5, len(key)) / 4.0
    order = rng.permutation(len(key))
    found = streaks(frame[order], key[order] + 7, value[order])
    by_key: dict[int, dict[int, float]] = defaultdict(dict)
    for k, f, v in zip(key.tolist(), frame.tolist(), value.tolist(), strict=True):
        by_key[k][f] = v
    expected = []
    for k, values in sorted(by_key.items()):
        whole = [f for f in range(25) if all(f + n in values for n in range(RUNNING))]
        if whole:
            level = max(min(values[f + n] for n in range(RUNNING)) for f in whole)
            expected.append((k + 7, level, whole[0]))
    assert list(zip(*(each.tolist() for each in found), strict=True)) == expected


@pytest.mark.parametrize("seed", range(4))
def test_chance_is_what_is_counted_draw_by_draw(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames = 40
    walk = {k: (-5.0 + 0.5 * k, 1.0) for k in range(12, 30)}
    people = [Intruder("person", walk), standing("car", (10.0, 3.0), range(30, 38))]
    objects = [objects_of(truth_of(people, k)) for k in range(frames)]
    names = rng.integers(0, 3, frames)
    answered = []
    for k in range(frames):
        at = [(-5.0 + 0.5 * rng.integers(0, 20), 1.0), (10.0, 3.0)]
        said = [track(10 * n + int(names[k] == n), at[n], "car", float(rng.random())) for n in range(2)]
        answers = answers_of(said, CAMERA, POSE)
        nobody = objects_of(truth_of([], k))
        answered.append(Answered(answers, Matcher().match(nobody, answers), np.zeros(2, np.uint8)))
    everywhere = Objects._make(map(np.array, zip(*objects, strict=True)))
    judged, place, box = everywhere.judged, everywhere.place_m, everywhere.box_xyxy
    found = chance_levels(history_of(answered), everywhere, np.random.default_rng(seed))
    shifts = np.random.default_rng(seed).integers(1, frames, DRAWS)
    for draw, shift in enumerate(shifts.tolist()):
        for n in range(2):
            levels = [-np.inf]
            for name in {int(each) for answer in answered for each in answer.answers.identity}:
                on = {}
                for k in range(frames):
                    answers = answered[(k + shift) % frames].answers
                    for m in np.flatnonzero(answers.identity == name):
                        near = np.hypot(*(answers.place_m[m, :2] - place[k, n, :2])) <= RADIUS_M
                        if judged[k, n] and near and boxes_meet(answers.box_xyxy[m], box[k, n]):
                            on[k] = answers.confidence[m]
                levels += [
                    min(on[k + j] for j in range(RUNNING)) for k in on if all(k + j in on for j in range(RUNNING))
                ]
            assert found[draw, n] == max(levels)
    assert np.isfinite(found).any()
    assert not np.isfinite(found).all()
