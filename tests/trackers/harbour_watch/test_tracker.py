"""``harbour_watch`` on a drawn quay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.trackers.harbour_watch.drawn_quay import CAMERA, SURVEY, T_WORLD_CAMERA, VIEW, Intruder, Quay
from trackers.registry import entry
from trackers.types import EgoPose

PERSON_M = (0.5, 0.5, 1.7)


def surveyed(name, seed=0, **changes):
    """Return a tracker that has the survey of the quay."""
    tracker = entry(name).create(np.random.default_rng(seed), **changes)
    tracker.survey(SURVEY)
    return tracker


def watch(seed: int, frames: int, intruders, **changes):
    """Return the answers of every frame; ``intruders(k)`` lists who is there."""
    quay = Quay(seed)
    tracker = surveyed("harbour_watch")
    tracker.survey(replace(SURVEY, **changes))
    tracker.start(quay.background(), CAMERA)
    return [tracker.update(quay.later(k, intruders(k))) for k in range(frames)]


def near(track, place_m, within_m=1.5):
    return bool(np.hypot(*(VIEW.place_of(track.estimate) - place_m)[:2]) < within_m)


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "most"), [("harbour_watch_doubts_first", 0.9), ("harbour_watch", 1.0)])
def test_who_stands_from_the_first_on_is_a_decision_but_not_among_the_surest(name, most):
    def there(k):
        return [Intruder((5.0, 2.0 if k < 12 else 2.0 + 1.2 * (k - 12), 0.0), PERSON_M, 2.0)]

    quay, tracker = Quay(3), surveyed(name)
    tracker.start(quay.background(), CAMERA)
    sure = [max((t.confidence for t in tracker.update(quay.later(k, there(k)))), default=0.0) for k in range(18)]
    assert sure[11] == pytest.approx(most, abs=1e-3)
    assert sure[17] > 0.999


@pytest.fixture(scope="module")
def stood():
    """A person walks in, stands still for five minutes and walks on."""

    def where(k):
        return (5.0, -8.0 + 1.2 * (min(max(k - 10, 0), 8) + max(k - 168, 0)), 0.0)

    answers = watch(1, 176, lambda k: [Intruder(where(k), PERSON_M, 0.8)] if k >= 10 else [])
    return where, answers


@pytest.mark.heavy
def test_a_person_who_stands_still_for_five_minutes_is_not_swallowed(stood):
    where, answers = stood
    found = [any(t.confidence > 0.9 and near(t, where(k)) for t in answers[k]) for k in range(12, 176)]
    assert np.mean(found) > 0.97
    assert all(found[-6:])


@pytest.mark.heavy
def test_one_person_is_one_track_with_the_size_of_a_person(stood):
    _, answers = stood
    sure = {t.identity for tracks in answers[12:] for t in tracks if t.confidence > 0.9}
    assert len(sure) == 1
    [track] = [t for t in answers[160] if t.confidence > 0.9]
    assert track.kind == "person"
    assert track.size_m[2] == pytest.approx(1.7, abs=0.15)


@pytest.mark.heavy
def test_cold_ground_where_a_car_has_parked_is_no_object():
    """It parks for two minutes, drives off, and the ground that it has shaded stays a kelvin colder."""

    def there(k):
        car = Intruder((5.0, -9.0 + 1.5 * (min(max(k - 4, 0), 6) + max(k - 70, 0)), 0.0), (1.8, 4.3, 1.5), 3.0)
        shaded = [Intruder((5.0, 0.0, 0.0), (1.8, 4.3, 0.1), -1.0)] if k > 72 else []
        return ([car] if 4 <= k < 78 else []) + shaded

    answers = watch(7, 110, there)
    assert any(t.kind == "car" and t.confidence > 0.9 for t in answers[60])
    assert not any(t.confidence > 0.5 for tracks in answers[85:] for t in tracks)


@pytest.mark.heavy
def test_tide_sun_and_waves_raise_no_alarm():
    answers = watch(2, 150, lambda k: [])
    assert sum(t.confidence > 0.5 for tracks in answers for t in tracks) == 0


def confident(answers, within):
    """Return for each frame of a slice the tracks that exist with 0.9 and more."""
    return [[t for t in tracks if t.confidence > 0.9] for tracks in answers[within]]


@pytest.mark.heavy
def test_a_second_person_on_the_line_of_sight_of_the_first_is_kept():
    """One walks until he stands right behind the other as the camera sees them, and stays."""
    front, back = (0.0, 0.0, 0.0), (14.0, 0.0, 0.0)

    def there(k):
        behind = (back[0], min(-8.0 + 1.0 * max(k - 6, 0), 0.0), 0.0)
        return [Intruder(each, PERSON_M, 1.2) for each in (front, behind)] if k >= 4 else []

    found = confident(watch(3, 50, there), slice(18, None))
    for place_m in (front, back):
        assert np.mean([any(near(t, place_m) for t in tracks) for tracks in found]) > 0.9
    assert np.mean([len(tracks) == 2 for tracks in found]) > 0.9
    assert len({t.identity for tracks in found for t in tracks}) == 2


@pytest.mark.heavy
@pytest.mark.parametrize("tide_m", [-0.6, 0.6])
def test_a_boat_is_placed_on_the_water_at_its_tide(tide_m):
    quay, tracker = Quay(4, wave_k=0.1), surveyed("harbour_watch")
    tides_m, suns = 0.8 * np.sin(0.12 * np.arange(60)), 0.5 + 0.5 * np.sin(0.37 * np.arange(60))
    shown = zip(tides_m, suns, strict=True)
    tracker.start([quay.picture(4320.0 * (k - 60), tide_m=t, sun=sun) for k, (t, sun) in enumerate(shown)], CAMERA)
    errors_m, kinds = [], []
    for k in range(40):
        base_m = (-26.0, -12.0 + 0.4 * k, -1.8 + tide_m)
        there = [Intruder(base_m, (2.2, 5.0, 1.5), 3.0)] if k >= 4 else []
        tracks = [t for t in tracker.update(quay.later(k, there, tide_m=tide_m)) if t.confidence > 0.9]
        if k >= 14:
            assert len(tracks) == 1
            errors_m.append(np.hypot(*(VIEW.place_of(tracks[0].estimate) - base_m)[:2]))
            kinds.append(tracks[0].kind)
    assert set(kinds) == {"boat"}
    # The quay would be 9 m behind it, and the mean level 3 m off.
    assert np.median(errors_m) < 1.5


def same(one, other):
    """Assert that two trackers answered alike."""
    for mine, others in zip(one, other, strict=True):
        assert [(t.identity, t.kind, t.confidence) for t in mine] == [
            (t.identity, t.kind, t.confidence) for t in others
        ]
        for a, b in zip(mine, others, strict=True):
            np.testing.assert_array_equal(a.estimate.box_xyxy, b.estimate.box_xyxy)
            np.testing.assert_array_equal(a.size_m, b.size_m)


def walk(k):
    return [Intruder((5.0, -8.0 + 1.2 * k, 0.0), PERSON_M, 0.8)] if k >= 2 else []


@pytest.fixture(scope="module")
def learnt(tmp_path_factory):
    """Return pictures of a walk, what a tracker answered on them, and what it had learnt as a file."""
    quay, tracker = Quay(6), surveyed("harbour_watch")
    tracker.start(quay.background(40), CAMERA)
    pictures = [quay.later(k, walk(k)) for k in range(12)]
    answers = [tracker.update(picture) for picture in pictures]
    # Saved after the walk: it is what ``start`` learnt, not what the walk has changed.
    return pictures, answers, tracker.save_background(tmp_path_factory.mktemp("models") / "quay")


@pytest.mark.heavy
def test_a_saved_background_answers_as_the_learnt_one(learnt):
    pictures, answers, path = learnt
    assert any(t.confidence > 0.9 for t in answers[-1])
    tracker = surveyed("harbour_watch")
    for _ in range(2):
        tracker.start_from(path, CAMERA, T_WORLD_CAMERA)
        same([tracker.update(picture) for picture in pictures], answers)


@pytest.mark.heavy
def test_the_same_pictures_give_the_same_answers(learnt):
    _, answers, _ = learnt
    quay, tracker = Quay(6), surveyed("harbour_watch", 9)
    tracker.start(quay.background(40), CAMERA)
    same([tracker.update(quay.later(k, walk(k))) for k in range(12)], answers)


def test_another_camera_and_another_input_are_refused_by_name(learnt):
    _, _, path = learnt
    tracker, moved = surveyed("harbour_watch"), T_WORLD_CAMERA.copy()
    moved[1, 3] += 3.0
    with pytest.raises(ValueError, match=r"model: expected one of this camera, .* place_m 3\.00 m away"):
        tracker.start_from(path, CAMERA, moved)
    with pytest.raises(ValueError, match="width_px 512 here and 256 there"):
        tracker.start_from(path, replace(CAMERA, width_px=512), T_WORLD_CAMERA)
    with pytest.raises(ValueError, match=r"model: expected one of harbour_watch-2 of 8 bits, .* of counts"):
        surveyed("harbour_watch_8_bit").start_from(path, CAMERA, T_WORLD_CAMERA)
    with pytest.raises(ValueError, match="background: expected pictures and a pose"):
        tracker.save_background(path)


@pytest.mark.heavy
@pytest.mark.parametrize("started", [True, False])
def test_a_pose_that_cannot_be_used_is_passed_over(started):
    quay, tracker = Quay(7), surveyed("harbour_watch")
    if started:
        tracker.start([replace(each, ego=None) for each in quay.background(30)], CAMERA)
    for pose in (np.full((4, 4), np.nan), np.zeros((4, 4))):
        assert tracker.update(replace(quay.later(0), ego=EgoPose(pose))) == []
    answers = [tracker.update(quay.later(k, walk(k))) for k in range(1, 14)]
    assert any(t.confidence > 0.9 for t in answers[-1]) or not started


@pytest.mark.heavy
def test_outside_the_watched_volume_nothing_is_found():
    answers = watch(6, 14, walk, watched_m=(20.0, 6.0, 6.0))
    # He enters from the right. Once found he may be followed out of it.
    assert not any(t.confidence > 0.5 and VIEW.place_of(t.estimate)[1] < -4.5 for tracks in answers for t in tracks)
    assert any(t.confidence > 0.9 for tracks in answers for t in tracks)
