"""The two trackers of paper B as written, on stereo pairs drawn by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.trackers.drawn_people import BLUE, CALM, CAMERA, GREEN, RED, Board, observation, person_box
from trackers import registry
from trackers.light_adaptive_stereo.occlusion import Occlusion
from trackers.light_adaptive_stereo.stereo_colour import (
    StereoColour,
    brightness_weight,
    combined_dissimilarity,
    position_dissimilarity,
)
from trackers.types import CameraSettings, EgoPose, Estimate

BOTH = ("stereo_wb", "stereo_wb_shutter_gain")
BRIGHTER = replace(CALM, shutter=520)
"""P_l = 6 * 30 / 177 > 1: with P_l in its weight, only the position counts."""


def start(name: str, person: Board, *others: Board) -> StereoColour:
    tracker = registry.entry(name).create(np.random.default_rng(0))
    tracker.initialise(observation([person, *others]), person_box(person))
    return tracker


def centre_px(person: Board) -> np.ndarray:
    box = person_box(person)
    return 0.5 * (box[:2] + box[2:])


def says_nothing(estimate: Estimate) -> bool:
    return bool(np.isnan(estimate.position_px).all()) and estimate.in_view_probability == 0.0


def predicts(estimate: Estimate, tracker: StereoColour) -> bool:
    """Return whether the answer is the place where the target is expected, and no candidate was found."""
    ahead_m, _ = tracker._filter.place_m
    return (
        not tracker._found_last and not says_nothing(estimate) and estimate.depth_m == pytest.approx(ahead_m, abs=0.01)
    )


def test_weights_by_hand():
    assert brightness_weight(0.1, 0.3, 0.0) == pytest.approx(0.4)
    assert brightness_weight(0.1, 0.3, 5.0) == pytest.approx(0.4)
    assert brightness_weight(0.1, 0.3, -0.25) == pytest.approx(0.65)
    wb, paper = (registry.entry(name).create(np.random.default_rng(0)) for name in BOTH)
    assert wb.weight(0.1, 0.3, -0.25) == 0.1
    assert paper.weight(0.1, 0.3, -0.25) == pytest.approx(0.65)


def test_dissimilarities_by_hand():
    places_m = np.array([[3.0, 0.0], [3.3, -0.4]])
    by_place = position_dissimilarity(places_m, np.array([3.0, 0.0]))
    np.testing.assert_allclose(by_place, [0.0, 0.5])
    by_colour = np.array([0.8, 0.2])
    np.testing.assert_allclose(combined_dissimilarity(0.25, by_colour, by_place), [0.6, 0.275])
    np.testing.assert_allclose(combined_dissimilarity(1.0, by_colour, by_place), by_place)
    np.testing.assert_allclose(combined_dissimilarity(1.7, by_colour, by_place), by_place)


@given(st.floats(0, 3), st.floats(0, 1), st.floats(0, 5))
def test_combined_dissimilarity_lies_between_its_two(weight, by_colour, by_place):
    combined = float(combined_dissimilarity(weight, np.array([by_colour]), np.array([by_place]))[0])
    assert min(by_colour, by_place) - 1e-9 <= combined <= max(by_colour, by_place) + 1e-9


def test_registered_for_the_stereo_suite_as_written():
    for name in BOTH:
        entry = registry.entry(name)
        assert (entry.role, entry.suites) == ("as-written", ("stereo",))
        assert {"threshold", "predicted_s"} <= set(entry.tunables())


@pytest.mark.parametrize("name", BOTH)
def test_follows_its_colour_while_the_light_stays(name):
    tracker = start(name, Board(3.0, 0.6), Board(3.2, -0.6, BLUE))
    # They change sides between two pictures: only colour tells them apart.
    person = Board(3.1, -0.5)
    estimate = tracker.update(observation([person, Board(3.0, 0.6, BLUE)], 1))
    assert estimate.position_px == pytest.approx(centre_px(person), abs=10)
    assert estimate.box_xyxy == pytest.approx(person_box(person), abs=16)
    assert estimate.depth_m == pytest.approx(person.ahead_m, rel=0.03)
    assert estimate.in_view_probability == 1.0


def test_place_decides_when_the_camera_says_that_the_light_has_changed():
    answers = {}
    for name in BOTH:
        tracker = start(name, Board(3.0, 0.6), Board(3.2, -0.6, BLUE))
        # The light makes the target's red green and the other's blue red.
        target, other = Board(3.0, 0.6, GREEN), Board(3.2, -0.6, RED)
        answers[name] = tracker.update(observation([target, other], 1, BRIGHTER))
    assert answers["stereo_wb_shutter_gain"].position_px == pytest.approx(centre_px(target), abs=10)
    assert answers["stereo_wb"].position_px == pytest.approx(centre_px(other), abs=10)


def test_template_and_reference_are_taken_anew_together():
    tracker = start("stereo_wb_shutter_gain", Board(3.0, 0.6))
    first, learnt_at = tracker._template, tracker._learnt_at
    assert learnt_at == CALM
    tracker.update(observation([Board(3.0, 0.6, GREEN)], 1, BRIGHTER))
    assert tracker._learnt_at == BRIGHTER
    assert not np.array_equal(tracker._template, first)
    # h rises by 10 * 30 / 177 in a frame, S = 130.
    assert tracker._learnt == pytest.approx(10 * 30 / 177 * 177 / 130)


def test_without_a_candidate_under_the_threshold_nothing_is_learnt():
    tracker = start("stereo_wb_shutter_gain", Board(3.0, 0.6))
    first = tracker._template
    assert predicts(tracker.update(observation([Board(3.0, 0.6, BLUE)], 1)), tracker)
    assert tracker._template is first


@pytest.mark.heavy
@pytest.mark.parametrize("name", BOTH)
def test_a_person_who_crosses_in_front_of_the_target_is_not_taken_for_it(name):
    paths = [(Board(3.2, 0.7 - 0.03 * f), Board(2.0, -0.7 + 0.05 * f, BLUE)) for f in range(32)]
    tracker = start(name, *paths[0])
    states, learnt_in, found = [], [], 0
    for frame, (target, other) in enumerate(paths[1:], 1):
        before = tracker._template
        estimate = tracker.update(observation([target, other], frame, replace(CALM, red=CALM.red + 10 * (frame % 2))))
        states.append(tracker._state.now)
        if tracker._template is not before:
            learnt_in.append(states[-1])
        assert not says_nothing(estimate)
        found += tracker._found_last
        assert np.hypot(*(estimate.position_px - centre_px(target))) < (30 if tracker._found_last else 60)
    order = [state for state, last in zip(states, [None, *states], strict=False) if state is not last]
    assert order == [Occlusion.NONE, Occlusion.STARTING, Occlusion.OCCLUDED, Occlusion.ENDING, Occlusion.NONE]
    assert set(learnt_in) == {Occlusion.NONE}
    assert 15 < found < len(states)


@pytest.mark.parametrize("name", BOTH)
def test_a_frame_without_the_right_picture_is_answered_by_prediction(name):
    tracker = start(name, Board(3.0, 0.0))
    for frame in range(1, 6):
        person = Board(3.0, -0.04 * frame)
        estimate = tracker.update(observation([person], frame, right=frame != 4))
        assert predicts(estimate, tracker) == (frame == 4)
        assert estimate.position_px == pytest.approx(centre_px(person), abs=12)
        assert estimate.box_xyxy == pytest.approx(person_box(person), abs=20)


def test_prediction_ends_where_the_target_is_lost_and_it_can_be_found_again():
    tracker = start("stereo_wb", Board(3.0, 0.0))
    for frame in range(1, 5):
        tracker.update(observation([Board(3.0, -0.05 * frame)], frame))
    lost_m, answered = [], []
    for frame in range(5, 40, 3):
        estimate = tracker.update(observation([], frame))
        assert predicts(estimate, tracker) == (not tracker._lost)
        assert says_nothing(estimate) == tracker._lost
        answered.append(not tracker._lost)
        lost_m.append(tracker._filter.place_m.copy())
    assert answered == sorted(answered, reverse=True)
    assert answered[0]
    assert not answered[-1]
    steps_m = np.linalg.norm(np.diff(lost_m, axis=0), axis=1)
    assert steps_m[0] > 0.05
    assert steps_m[-1] == 0.0
    back = Board(3.0, 0.9)
    assert tracker.update(observation([back], 40)).position_px == pytest.approx(centre_px(back), abs=10)
    assert tracker._filter.place_m == pytest.approx([3.0, 0.9], abs=0.1)


@pytest.mark.parametrize(
    "box_xyxy", [(900, 100, 960, 300), (0, 0, 40, 90), (300, 470, 340, 700)], ids=["outside", "empty", "below"]
)
@pytest.mark.parametrize("right", [True, False])
def test_a_first_box_off_the_person_does_no_harm(box_xyxy, right):
    tracker = registry.entry("stereo_wb").create(np.random.default_rng(0))
    tracker.initialise(observation([Board(3.0, 0.0)], right=right), np.array(box_xyxy, dtype=float))
    for frame in range(1, 4):
        estimate = tracker.update(observation([Board(3.0, 0.0)], frame))
        # Whatever is found is the only person in the picture.
        if tracker._found_last:
            assert estimate.position_px == pytest.approx(centre_px(Board(3.0, 0.0)), abs=10)
        else:
            assert says_nothing(estimate) or predicts(estimate, tracker)


@pytest.mark.heavy
def test_an_occluder_at_the_last_position_does_not_make_it_valid_again():
    tracker = start("stereo_wb", Board(3.0, 0.0))
    lost = []
    for frame in range(1, 40):
        before = [Board(1.8, 0.0, BLUE)] if 25 <= frame < 32 else []
        assert says_nothing(tracker.update(observation(before, frame))) == tracker._lost
        lost.append(tracker._lost)
    assert not lost[0]
    assert lost == sorted(lost)
    assert lost[24]


def test_starts_without_the_first_right_picture():
    tracker = registry.entry("stereo_wb").create(np.random.default_rng(0))
    person = Board(3.0, 0.3)
    tracker.initialise(observation([person], right=False), person_box(person))
    assert tracker._filter.place_m == pytest.approx([3.0, 0.3], abs=0.15)
    assert tracker.update(observation([person], 1)).position_px == pytest.approx(centre_px(person), abs=10)


def test_the_measured_pose_says_how_the_camera_stands():
    tracker = registry.entry("stereo_wb").create(np.random.default_rng(0))
    T_world_camera = np.array([[0.0, 0, 1, 5], [-1, 0, 0, 2], [0, -1, 0, 1.2], [0, 0, 0, 1]])
    person = Board(3.0, 0.3)
    tracker.initialise(replace(observation([person]), ego=EgoPose(T_world_camera)), person_box(person))
    assert tracker._filter.place_m == pytest.approx([3.0, 0.3], abs=0.1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"camera": replace(CAMERA, baseline_m=None)}, r"camera\.baseline_m: expected .* got None"),
        ({"settings": None}, r"settings\.registers: expected .* got None"),
        ({"settings": CameraSettings(0.01, 1.0)}, r"settings\.registers: expected .* got None"),
        (
            {"settings": CameraSettings(0.01, 1.0, replace(CALM, shutter=708))},
            r"settings\.registers\.shutter: expected 0 to 707, got 708",
        ),
    ],
)
def test_errors_say_what_was_expected(changes, message):
    tracker = registry.entry("stereo_wb").create(np.random.default_rng(0))
    with pytest.raises(ValueError, match=message):
        tracker.initialise(replace(observation([]), **changes), np.array([300.0, 100.0, 360.0, 400.0]))
