"""The view of a stereo pair: mounting by the first picture, and one view for all trackers."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from tests.trackers import drawn_people
from tests.trackers.drawn_people import BLUE, CAMERA_HEIGHT_M, GREEN, LEVEL, RED, Board, observation, person_box
from trackers.light_adaptive_stereo.candidates import CandidateParameters
from trackers.light_adaptive_stereo.matching import MatchingParameters, StereoMatcher
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.light_adaptive_stereo.stereo_view import first_mounting, see
from trackers.protocols import OutsourcingTracker
from trackers.registry import entry
from trackers.types import Estimate, Observation

NAMES = ("stereo_wb", "stereo_wb_shutter_gain", "stereo_nearest", "stereo_colour_gate", "stereo_people")
PERSON = Board(3.0, 0.2, RED)


@pytest.fixture(autouse=True)
def _undo_the_kept_background(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn_people, "_background", drawn_people._background.__wrapped__)


@pytest.mark.parametrize("right", [True, False])
@pytest.mark.parametrize("height_m", [0.6, 1.2, 1.6])
def test_the_height_is_found(height_m: float, right: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn_people, "CAMERA_HEIGHT_M", height_m)
    found = first_mounting(observation([PERSON], right=right), person_box(PERSON), StereoMatcher(), 1.7)
    assert found.height_m == pytest.approx(height_m, rel=0.1)


@pytest.mark.heavy
@pytest.mark.parametrize("name", NAMES)
def test_trackers_follow_from_a_low_camera_whose_height_nobody_tells(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawn_people, "CAMERA_HEIGHT_M", 0.6)
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(observation([PERSON]), person_box(PERSON))
    estimate = tracker.update(observation([PERSON], 1))
    assert estimate.in_view_probability >= 0.5
    assert estimate.box_xyxy == pytest.approx(person_box(PERSON), abs=25)


OTHER = Board(3.6, -1.0, BLUE)


def walk() -> list[Observation]:
    boards = ([replace(PERSON, left_m=0.2 + 0.06 * k), OTHER, Board(2.5, 1.4 - 0.1 * k, GREEN)] for k in range(5))
    return [observation(each, k) for k, each in enumerate(boards)]


def started(name: str, first: Observation) -> OutsourcingTracker:
    tracker = entry(name).create(np.random.default_rng(0), **entry(name).written())
    tracker.initialise(first, person_box(PERSON))
    assert isinstance(tracker, OutsourcingTracker)
    return tracker


def numbers(estimate: Estimate) -> list[float]:
    box = np.full(4, np.nan) if estimate.box_xyxy is None else estimate.box_xyxy
    return [*estimate.position_px, *box, np.nan if estimate.depth_m is None else estimate.depth_m]


@pytest.mark.heavy
def test_side_by_side_they_answer_as_alone_and_count_the_shared_time():
    frames = walk()
    alone = {}
    for name in NAMES:
        tracker = started(name, frames[0])
        alone[name] = [numbers(tracker.update(frame)) for frame in frames[1:]]
        assert tracker.elsewhere_cpu_s == 0.0
    # None of them has seen these.
    frames = walk()
    trackers = [started(name, frames[0]) for name in NAMES]
    for k, frame in enumerate(frames[1:]):
        for name, tracker in zip(NAMES, trackers, strict=True):
            began_s = time.thread_time()
            np.testing.assert_array_equal(numbers(tracker.update(frame)), alone[name][k])
            if tracker is trackers[0]:
                whole_s = time.thread_time() - began_s
            assert 0.0 <= tracker.elsewhere_cpu_s <= whole_s
            assert (tracker.elsewhere_cpu_s == 0.0) == (tracker is trackers[0])


def test_a_view_is_shared_for_one_picture_seen_in_one_way():
    frame, matcher, parameters = walk()[0], StereoMatcher(), CandidateParameters()
    view, elsewhere_s = see(frame, matcher, LEVEL, parameters)
    assert elsewhere_s == 0.0
    again, elsewhere_s = see(frame, StereoMatcher(), Mounting.level(CAMERA_HEIGHT_M), CandidateParameters())
    assert again is view
    assert elsewhere_s > 0.0
    others = (
        (replace(frame), matcher, LEVEL, parameters),
        (frame, StereoMatcher(MatchingParameters(check_px=2)), LEVEL, parameters),
        (frame, matcher, Mounting.level(CAMERA_HEIGHT_M + 0.1), parameters),
        (frame, matcher, replace(LEVEL, R_robot_camera=-LEVEL.R_robot_camera), parameters),
        (frame, matcher, LEVEL, CandidateParameters(widest_m=1.1)),
    )
    for other in others:
        see(frame, matcher, LEVEL, parameters)
        assert see(*other)[1] == 0.0


def test_nobody_can_change_what_others_see():
    view, _ = see(walk()[0], StereoMatcher(), LEVEL, CandidateParameters())
    assert view is not None
    assert view.candidates
    for array in (view.depth_m, view.points_m, view.candidates[0].place_m, view.candidates[0].box_xyxy):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
