"""The stereo baselines on drawn pairs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.trackers.drawn_people import BLUE, CAMERA, GREEN, RED, Board, observation, person_box, place_of, posed
from trackers.estimate_check import check_estimate
from trackers.protocols import Tracker
from trackers.registry import entry

NAMES = ("stereo_nearest", "stereo_colour_gate")
PERSON, OTHER = Board(3.0, 0.2, RED), Board(3.6, -1.0, BLUE)
WALL = Board(1.6, 0.1, GREEN, 2.6, 2.6, head=False)


def started(name: str, *boards: Board, **changes: float) -> Tracker:
    tracker = entry(name).create(np.random.default_rng(0), **changes)
    tracker.initialise(observation(boards), person_box(boards[0]))
    return tracker


@pytest.mark.parametrize("name", NAMES)
def test_it_answers_where_the_person_is(name: str) -> None:
    tracker = started(name, PERSON, OTHER)
    for frame in range(1, 4):
        moved = replace(PERSON, left_m=PERSON.left_m + 0.06 * frame)
        estimate = tracker.update(observation([moved, OTHER], frame))
    assert estimate.in_view_probability == 1.0
    assert place_of(estimate) == pytest.approx([3.0, 0.38], abs=0.15)
    assert estimate.box_xyxy == pytest.approx(person_box(moved), abs=25)


@pytest.mark.heavy
@pytest.mark.parametrize("name", NAMES)
def test_a_hidden_person_is_predicted_then_lost_then_found(name: str) -> None:
    """With the values as written: tuned ones predict for another time."""
    tracker = started(name, PERSON, **entry(name).written())
    hidden = [tracker.update(observation([PERSON, WALL], frame)) for frame in range(3, 16, 3)]
    assert hidden[1].in_view_probability == 0.5
    assert place_of(hidden[1]) == pytest.approx([3.0, 0.2], abs=0.3)
    assert np.isnan(hidden[-1].position_px).all()
    assert hidden[-1].in_view_probability == 0.0
    back = tracker.update(observation([replace(PERSON, left_m=0.5)], 16))
    assert place_of(back) == pytest.approx([3.0, 0.5], abs=0.15)


@pytest.mark.heavy
def test_colours_tell_a_lost_person_from_a_nearer_one() -> None:
    answers = {}
    for name in NAMES:
        tracker = started(name, PERSON)
        for frame in range(3, 16, 3):
            tracker.update(observation([PERSON, WALL], frame))
        seen = [replace(PERSON, left_m=1.1), replace(OTHER, ahead_m=3.1, left_m=-0.1)]
        answers[name] = place_of(tracker.update(observation(seen, 16)))[1]
    assert answers["stereo_nearest"] == pytest.approx(-0.1, abs=0.15)
    assert answers["stereo_colour_gate"] == pytest.approx(1.1, abs=0.15)


@pytest.mark.parametrize("name", NAMES)
def test_a_prediction_stays_on_the_ground_when_the_robot_turns(name: str) -> None:
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(posed(observation([PERSON]), 0.0), person_box(PERSON))
    unseen = posed(observation([PERSON], 1, right=False), 0.3)
    estimate = tracker.update(unseen)
    c, s = np.cos(0.3), np.sin(0.3)
    assert place_of(estimate) == pytest.approx([c * 3.0 + s * 0.2, c * 0.2 - s * 3.0], abs=0.15)


@pytest.mark.heavy
@settings(max_examples=8, deadline=None)
@given(
    st.sampled_from(NAMES),
    st.tuples(st.floats(-60, 660), st.floats(-60, 500), st.floats(0.01, 300), st.floats(0.01, 400)),
    st.booleans(),
    st.sampled_from([0.0, 1e-6, 0.07, 100.0]),
)
def test_answers_are_valid_wherever_it_starts(
    name: str, start: tuple[float, float, float, float], right: bool, seconds: float
) -> None:
    x, y, width, height = start
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(observation([PERSON], right=right), np.array([x, y, x + width, y + height]))
    for frame, shown in enumerate((True, False, True), 1):
        seen = observation([PERSON], frame, right=shown)
        check_estimate(tracker.update(replace(seen, time_s=seconds * frame)))


@pytest.mark.parametrize("name", NAMES)
def test_a_box_that_is_none_and_a_single_camera_are_refused(name: str) -> None:
    tracker = entry(name).create(np.random.default_rng(0))
    with pytest.raises(ValueError, match="box_xyxy: expected"):
        tracker.initialise(observation([PERSON]), np.array([5.0, 5.0, 5.0, 9.0]))
    single = replace(observation([PERSON]), camera=replace(CAMERA, baseline_m=None))
    with pytest.raises(ValueError, match="baseline_m"):
        tracker.initialise(single, person_box(PERSON))
