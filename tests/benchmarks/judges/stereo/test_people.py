"""Right, wrong, missed, on another person: each rule by hand, and all of them against a plain loop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.judges.stereo.metrics import people
from benchmarks.judges.stereo.metrics.people import Outcome
from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.truth import PeopleTruth
from sim.optics import project
from tests.benchmarks.judges.follow.fake_follow import CAMERA, FakeFollow, FakeFollowEpisode
from tests.benchmarks.judges.stereo.hand_made_people import NOWHERE, OTHER_M, people_of
from trackers.types import Estimate

PIXEL = np.array([10.0, 20.0])


@pytest.fixture
def truth() -> PeopleTruth:
    frame = FakeFollowEpisode(FakeFollow("one"), closed_loop=False).step()
    assert isinstance(frame.truth, PeopleTruth)
    return frame.truth


@pytest.mark.parametrize(
    ("position", "probability", "answer"),
    [
        ((1.0, 2.0), None, True),
        ((1.0, 2.0), 0.5, True),
        ((1.0, 2.0), 0.49, False),
        ((np.nan, np.nan), None, False),
        ((np.nan, np.nan), 0.9, False),
        ((-900.0, 2.0), 0.9, True),
    ],
)
def test_a_finite_position_with_half_a_probability_is_an_answer(
    position: tuple[float, float], probability: float | None, answer: bool
) -> None:
    assert people.answers(Estimate(np.array(position), in_view_probability=probability)) is answer


@settings(deadline=None)
@given(
    place=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    heading=st.floats(-3.1, 3.1),
    ahead=st.floats(0.5, 20),
    aside=st.floats(-3, 3),
    height=st.floats(-1, 3),
)
def test_a_measured_depth_leads_back_to_the_place(
    place: tuple[float, float], heading: float, ahead: float, aside: float, height: float
) -> None:
    """Independent of the code: a point is put before the camera by its heading, and projected."""
    frame = FakeFollowEpisode(FakeFollow("one"), closed_loop=False).step()
    assert isinstance(frame.truth, PeopleTruth)
    pose = camera_pose(np.array(place), heading)
    forward, left = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    spot = np.array(place) + ahead * forward + aside * left
    pixel, depth = project(CAMERA, pose, np.array([*spot, height]))
    assert depth == pytest.approx(ahead)
    found = people.answered_place_m(
        Estimate(pixel, depth_m=float(depth)), replace(frame.truth, T_world_camera=pose), CAMERA
    )
    assert found == pytest.approx(spot, abs=1e-6)


def test_without_a_depth_the_one_that_its_pixel_shows_is_lent(truth: PeopleTruth) -> None:
    depth = np.full((CAMERA.height_px, CAMERA.width_px), 9.0, dtype=np.float32)
    depth[20, 10] = 3.0
    truth = replace(truth, depth_m=depth)

    def ahead_m(x: float, y: float) -> float:
        return float(people.answered_place_m(Estimate(np.array([x, y])), truth, CAMERA)[0])

    # Pixel (row 20, column 10) covers [10, 11) x [20, 21).
    assert [ahead_m(*at) for at in ((10.0, 20.0), (10.99, 20.99), (11.0, 20.0), (10.0, 21.0))] == [3.0, 3.0, 9.0, 9.0]
    assert people.answered_place_m(Estimate(PIXEL, depth_m=5.0), truth, CAMERA)[0] == pytest.approx(5.0)


@pytest.mark.parametrize("position", [(-0.01, 5.0), (160.0, 5.0), (5.0, 120.0), (5.0, -1.0), NOWHERE, (10.0, 20.0)])
def test_outside_the_picture_and_in_the_sky_there_is_no_depth_to_lend(
    truth: PeopleTruth, position: tuple[float, float]
) -> None:
    sky = replace(truth, depth_m=np.full_like(truth.depth_m, np.inf))
    assert np.isnan(people.answered_place_m(Estimate(np.array(position)), sky, CAMERA)).all()
    inside = position == (10.0, 20.0)
    assert np.isnan(people.answered_place_m(Estimate(np.array(position)), truth, CAMERA)).all() != inside


def test_a_measured_depth_counts_outside_the_picture_too(truth: PeopleTruth) -> None:
    place = people.answered_place_m(Estimate(np.array([-40.0, 60.0]), depth_m=3.0), truth, CAMERA)
    assert place == pytest.approx([3.0, 3.0])


@pytest.mark.parametrize(
    ("visible", "place", "expected"),
    [
        (1.0, (0.5, 0.0), Outcome.RIGHT),
        (1.0, (0.51, 0.0), Outcome.WRONG),
        (0.05, (0.1, 0.0), Outcome.RIGHT),
        (0.05, (3.0, 3.0), Outcome.WRONG),
        (1.0, NOWHERE, Outcome.WRONG),
        (1.0, None, Outcome.MISSED),
        (0.1, None, Outcome.MISSED),
        (0.09, None, Outcome.UNCOUNTED),
        (0.0, None, Outcome.UNCOUNTED),
        (0.0, (0.1, 0.0), Outcome.UNCOUNTED),
        (0.0, (3.0, 3.0), Outcome.UNCOUNTED),
        (1.0, (OTHER_M[0] + 0.4, 0.0), Outcome.WRONG_PERSON),
        (0.05, (OTHER_M[0] + 0.4, 0.0), Outcome.WRONG_PERSON),
        (1.0, (OTHER_M[0] + 0.51, 0.0), Outcome.WRONG),
        (0.0, (OTHER_M[0] + 0.4, 0.0), Outcome.UNCOUNTED_WRONG_PERSON),
    ],
)
def test_what_a_frame_counts_as(visible: float, place: tuple[float, float] | None, expected: Outcome) -> None:
    truth = people_of([1.0, visible])
    given = np.array([True, place is not None])
    places = np.array([(0.0, 0.0), place or (0.0, 0.0)])
    assert people.outcomes(truth, given, places).tolist() == [Outcome.UNCOUNTED, expected]


def test_who_is_right_is_on_nobody_else_however_near_he_stands() -> None:
    truth = people_of([1.0, 1.0, 0.0], others_m=np.array([[0.6, 0.0]]))
    places = np.array([[0.45, 0.0]] * 3)
    assert people.outcomes(truth, np.ones(3, bool), places).tolist() == [0, Outcome.RIGHT, Outcome.UNCOUNTED]
    assert people.on_other(truth, places).tolist() == [-1, -1, -1]


def test_of_several_others_it_is_on_the_nearest() -> None:
    truth = people_of([1.0], others_m=np.array([[2.0, 0.0], [2.3, 0.0], [9.0, 0.0]]))
    assert people.on_other(truth, np.array([[2.2, 0.0]])).tolist() == [2]
    assert people.on_other(truth, np.array([[2.05, 0.0]])).tolist() == [1]


def test_errors_are_capped_and_an_absent_answer_has_the_worst() -> None:
    truth = people_of([1.0] * 5)
    places = np.array([[0.0, 0.0], [3.0, 4.0], [0.3, 0.4], [30.0, 0.0], NOWHERE])
    given = np.array([True, True, True, True, True])
    assert people.position_error_m(truth, given, places) == pytest.approx([0.0, 5.0, 0.5, 5.0, 5.0])
    assert people.position_error_m(truth, ~given, places) == pytest.approx([5.0] * 5)


frames = st.lists(
    st.tuples(
        st.sampled_from([0.0, 0.05, 0.0999, 0.1, 0.3, 1.0]),
        st.booleans(),
        st.one_of(st.just(NOWHERE), st.tuples(st.floats(-3, 3), st.floats(-3, 3))),
        st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), min_size=2, max_size=2),
    ),
    min_size=1,
    max_size=20,
)


@settings(deadline=None)
@given(frames)
def test_every_frame_is_accounted_for_as_a_plain_loop_does(
    data: list[tuple[float, bool, tuple[float, float], list[tuple[float, float]]]],
) -> None:
    truth = people_of([visible for visible, *_ in data])
    others = np.array([each for *_, each in data], dtype=float)
    truth = replace(truth, ground_m=np.concatenate([np.zeros((len(data), 1, 2)), others], axis=1))
    given = np.array([answer for _, answer, *_ in data])
    places = np.array([place for _, _, place, _ in data], dtype=float)
    outcome = people.outcomes(truth, given, places)
    right = wrong = missed = on_other = answered = silent = 0
    for k, (visible, answer, place, bystanders) in enumerate(data):
        if k == 0:
            continue
        to_target = np.hypot(*place)
        to_others = [np.hypot(place[0] - x, place[1] - y) for x, y in bystanders]
        correct = answer and to_target <= 0.5
        if answer and not correct and any(d < 0.5 and d < to_target for d in to_others):
            on_other += 1
        if visible == 0:
            continue
        answered += answer
        silent += not answer and visible >= 0.1
        right += correct
        wrong += answer and not correct
        missed += not answer and visible >= 0.1
    assert people.counts(outcome) == (right, wrong, missed)
    assert people.on_wrong_person(outcome).sum() == on_other
    assert right + wrong == answered
    assert missed == silent
    assert right + wrong + missed == (~np.isin(outcome, (0, 5))).sum()
