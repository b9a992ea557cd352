"""``stereo_people`` on drawn pairs, whatever its parameters are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_people import BLUE, CALM, CAMERA, RED, Board, observation, person_box, place_of, posed
from trackers.protocols import Tracker
from trackers.registry import entry
from trackers.stereo_people import tracker as tracker_module
from trackers.stereo_people.tracks import Track, associate
from trackers.types import Estimate, Observation

VARIANTS = ("stereo_people_no_light", "stereo_people_no_odometry", "stereo_people_no_others", "stereo_people_no_nearby")
PERSON = Board(3.0, 0.2, RED)
OTHER = Board(3.6, -1.0, BLUE, 0.55, 1.85)


def new_tracker(name: str = "stereo_people") -> Tracker:
    return entry(name).create(np.random.default_rng(0))


def started(name: str, *boards: Board, frame: int = 0) -> Tracker:
    tracker = new_tracker(name)
    tracker.initialise(observation(boards, frame), person_box(boards[0]))
    return tracker


def turned(boards: Iterable[Board], heading_rad: float, frame: int, right: bool = True) -> Observation:
    """Return what a robot sees that has turned on the spot; boards are where they are at heading 0."""
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    there = [
        replace(
            board,
            ahead_m=cosine * board.ahead_m + sine * board.left_m,
            left_m=cosine * board.left_m - sine * board.ahead_m,
        )
        for board in boards
    ]
    return posed(observation(there, frame, right=right), heading_rad)


def on_ground(estimate: Estimate, heading_rad: float) -> NDArray[np.float64]:
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    place: NDArray[np.float64] = np.array([[cosine, -sine], [sine, cosine]]) @ place_of(estimate)
    return place


def test_it_answers_where_the_person_is():
    tracker = started("stereo_people", PERSON, OTHER)
    for frame in range(1, 5):
        moved = replace(PERSON, left_m=PERSON.left_m + 0.06 * frame)
        estimate = tracker.update(observation([moved, OTHER], frame))
    assert estimate.in_view_probability == pytest.approx(1.0)
    # The body's axis is some 10 cm behind its visible surface.
    assert place_of(estimate) == pytest.approx([3.1, 0.45], abs=0.2)
    assert estimate.box_xyxy == pytest.approx(person_box(moved), abs=25)


def test_a_robot_that_turns_on_the_spot_leaves_people_in_place():
    tracker = new_tracker()
    tracker.initialise(turned([PERSON], 0.0, 0), person_box(PERSON))
    places_m = []
    for frame in range(1, 8):
        heading_rad = -0.06 * frame
        places_m.append(on_ground(tracker.update(turned([PERSON], heading_rad, frame)), heading_rad))
    np.testing.assert_allclose(places_m, np.tile([3.1, 0.2], (7, 1)), atol=0.15)


def test_without_odometry_an_unseen_person_turns_with_the_robot():
    places_m = []
    for name in ("stereo_people", "stereo_people_no_odometry"):
        tracker = new_tracker(name)
        tracker.initialise(turned([PERSON], 0.0, 0), person_box(PERSON))
        for frame in range(1, 4):
            tracker.update(turned([PERSON], 0.0, frame))
        estimate = tracker.update(turned([PERSON], -0.3, 4, right=False))
        places_m.append(on_ground(estimate, -0.3))
    assert places_m[0] == pytest.approx([3.1, 0.2], abs=0.2)
    assert np.linalg.norm(places_m[1] - places_m[0]) > 0.6


def test_a_lost_right_picture_is_bridged_for_a_while():
    tracker = started("stereo_people", PERSON)
    for frame in range(1, 4):
        tracker.update(observation([PERSON], frame))
    bridged = tracker.update(observation([PERSON], 4, right=False))
    assert place_of(bridged) == pytest.approx([3.1, 0.2], abs=0.25)
    later = tracker.update(observation([PERSON], 90, right=False))
    assert np.isnan(later.position_px).all()
    assert later.in_view_probability == 0.0
    back = tracker.update(observation([PERSON], 91))
    assert place_of(back) == pytest.approx([3.1, 0.2], abs=0.25)


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["stereo_people", *VARIANTS])
def test_an_empty_view_is_no_error(name):
    tracker = new_tracker(name)
    tracker.initialise(observation([]), person_box(PERSON))
    for frame, right in ((1, True), (2, False), (3, True), (60, True), (61, True)):
        estimate = tracker.update(observation([], frame, right=right))
        assert estimate.position_px.shape == (2,)
    assert np.isnan(estimate.position_px).all()


def test_it_may_start_without_a_right_picture():
    tracker = new_tracker()
    tracker.initialise(observation([PERSON], right=False), person_box(PERSON))
    estimate = [tracker.update(observation([PERSON], frame)) for frame in (1, 2)][-1]
    assert place_of(estimate) == pytest.approx([3.1, 0.2], abs=0.4)


def test_missing_registers_and_baseline_are_named():
    frame = observation([PERSON])
    for broken, message in (
        (replace(frame, settings=None), "settings.registers: expected"),
        (replace(frame, settings=replace(frame.settings, registers=None)), "settings.registers: expected"),
        (
            replace(frame, settings=replace(frame.settings, registers=replace(CALM, gain=900))),
            "gain: expected 0 to 683",
        ),
        (replace(frame, camera=replace(CAMERA, baseline_m=None)), "baseline"),
    ):
        with pytest.raises(ValueError, match=message):
            new_tracker().initialise(broken, person_box(PERSON))


def test_the_same_pairs_get_the_same_answers():
    runs = []
    for _ in range(2):
        tracker = started("stereo_people", PERSON, OTHER)
        answers = [tracker.update(observation([PERSON, OTHER], frame, right=frame != 2)) for frame in range(1, 5)]
        runs.append(np.array([[*answer.position_px, answer.depth_m] for answer in answers]))
    np.testing.assert_array_equal(*runs)


@pytest.mark.parametrize(("name", "used"), [("stereo_people", True), ("stereo_people_no_light", False)])
def test_light_is_estimated_from_picture_and_registers(monkeypatch, name, used):
    given = []
    predict = Track.predict

    def spy(track, seconds, shift, loosened):
        given.append((float(np.abs(shift).max()), loosened))
        predict(track, seconds, shift, loosened)

    monkeypatch.setattr(Track, "predict", spy)
    tracker = started(name, PERSON)
    frame = observation([PERSON], 1, replace(CALM, red=700))
    tracker.update(replace(frame, image_rgb=(0.6 * frame.image_rgb).astype(np.uint8)))
    assert (given[0][0] > 0.3, given[0][1] > 0) == (used, used)


@pytest.mark.parametrize(("name", "tracks"), [("stereo_people", 2), ("stereo_people_no_others", 1)])
def test_others_are_followed_too(monkeypatch, name, tracks):
    counts = []

    def spy(followed, sightings):
        counts.append((len(followed), len(sightings)))
        return associate(followed, sightings)

    monkeypatch.setattr(tracker_module, "associate", spy)
    tracker = started(name, PERSON, OTHER)
    tracker.update(observation([PERSON, OTHER], 1))
    assert counts == [(tracks, 2)]


@pytest.mark.parametrize(("name", "looks"), [("stereo_people", True), ("stereo_people_no_nearby", False)])
def test_a_half_hidden_person_is_seen_at_the_expected_place(name, looks):
    """A post as wide as an arm is no candidate, but at the expected place it is taken for a part of the person."""
    tracker = started(name, PERSON)
    for frame in range(1, 4):
        tracker.update(observation([PERSON], frame))
    sliver = replace(PERSON, width_m=0.14, head=False)
    estimate = [tracker.update(observation([sliver], frame)) for frame in range(4, 7)][-1]
    assert (estimate.in_view_probability == 1.0) == looks


@pytest.mark.heavy
def test_another_person_is_not_taken_for_the_lost_target():
    """The target goes behind a wall; the person who stood beside it all the time is another one."""
    tracker = started("stereo_people", PERSON, OTHER)
    for frame in range(1, 13):
        tracker.update(observation([PERSON, OTHER], frame))
    for frame in range(13, 26):
        estimate = tracker.update(observation([OTHER], frame))
        if np.isfinite(estimate.position_px).all():
            assert np.linalg.norm(place_of(estimate) - (OTHER.ahead_m, OTHER.left_m)) > 0.7


def test_a_track_that_continues_a_lost_one_keeps_learning_its_height():
    view = started("stereo_people", PERSON)
    seen = view._target.latest
    parameters = view._tracks_parameters
    lost, other = (Track(replace(seen, height_m=height_m), 0.0, parameters) for height_m in (1.8, 1.6))
    for _ in range(30):
        lost.correct(replace(seen, height_m=1.8), 0.0)
    other.continue_lost(lost)
    other.correct(replace(seen, height_m=1.5), 0.1)
    assert other.height_m == pytest.approx(1.79, abs=0.005)
    unknown, other = (Track(replace(seen, height_m=height_m), 0.0, parameters) for height_m in (np.nan, 1.6))
    other.continue_lost(unknown)
    other.correct(replace(seen, height_m=1.7), 0.1)
    assert other.height_m == pytest.approx(1.7)
