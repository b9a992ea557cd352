"""Metrics of following: cases made by hand, and properties of all cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.judges.follow.metrics import following
from tests.benchmarks.hand_made import IN_VIEW_OR_NOT, view
from tests.benchmarks.judges.follow import fake_follow
from tests.benchmarks.judges.follow.fake_follow import boxes_xyxy, middles_px

RATE_HZ = 10.0


def test_centring_error_is_over_frames_in_view_after_the_first() -> None:
    corner, middle, border = [0.0, 0.0], [80.0, 60.0], [160.0, 60.0]
    position_px = np.array([corner, middle, border, corner, [np.nan, np.nan]])
    in_view = np.array([True, True, True, True, False])
    assert following.centring_error(position_px, (160, 120), in_view) == pytest.approx((0.0 + 0.8 + 1.0) / 3)
    assert np.isnan(following.centring_error(position_px, (160, 120), np.array([True, *[False] * 4])))


def test_effort_is_between_nothing_and_everything() -> None:
    assert following.effort(np.zeros((5, 3))) == 0.0
    assert following.effort(np.array([[1.0, -1.0, 1.0]] * 4)) == pytest.approx(1.0)
    # One axis of four at its limit, half of the time.
    assert following.effort(np.array([[1.0, 0, 0, 0], [0, 0, 0, 0]])) == pytest.approx(0.25)


def test_jerkiness_counts_changes_from_rest_on() -> None:
    held = np.array([[1.0, 0.0]] * 4)
    assert following.jerkiness_per_s(held, RATE_HZ) == pytest.approx(RATE_HZ / 4 / np.sqrt(2))
    to_and_fro = np.array([[1.0], [-1.0], [1.0], [-1.0]])
    assert following.jerkiness_per_s(to_and_fro, RATE_HZ) == pytest.approx(RATE_HZ * (1 + 3 * 2) / 4)


@given(
    st.integers(1, 4).flatmap(
        lambda axes: st.lists(st.lists(st.floats(-1, 1), min_size=axes, max_size=axes), min_size=1, max_size=20)
    )
)
def test_no_command_costs_more_than_all(commands: list[list[float]]) -> None:
    shares = np.array(commands)
    assert 0.0 <= following.effort(shares) <= 1.0 + 1e-12
    assert 0.0 <= following.jerkiness_per_s(shares, RATE_HZ) <= 2.0 * RATE_HZ + 1e-9
    assert following.effort(-shares) == pytest.approx(following.effort(shares))


def test_the_pixel_says_whom_an_estimate_is_on() -> None:
    truth = fake_follow.FAKE_FOLLOW.episode("tiny", 0).step().truth
    ids = truth.instance_map.copy()
    for person in (1, 2):
        x0, y0, x1, y1 = np.round(boxes_xyxy(0)[person]).astype(int)
        ids[y0:y1, max(x0, 0) : max(x1, 0)] = truth.instance_id[person]
    ids[:, :2] = 99
    truth = replace(truth, instance_map=ids)
    target, _, stander = middles_px(0)
    assert following.is_on_target(target, truth, 0)
    assert not following.is_on_other(target, truth, 0)
    assert following.is_on_other(stander, truth, 0)
    assert not following.is_on_target(stander, truth, 0)
    # On a wall or a piece of furniture, nowhere, outside: on no person.
    for place in ([1.0, 5.0], [np.nan, np.nan], [-30.0, 60.0], [30.0, 1e4]):
        assert not following.is_on_other(np.array(place), truth, 0)
        assert not following.is_on_target(np.array(place), truth, 0)


def test_dat_counts_the_middle_full_and_the_outside_nothing() -> None:
    centring = np.array([1.0, 1.0, 0.5, 0.0])
    assert following.dat_cumulative_reward(centring) == pytest.approx(np.tanh(4.0) + np.tanh(0.5))
    assert following.dat_tsr(centring) == pytest.approx(2 / 3)


def test_the_rivals_episode_ends_with_two_seconds_out_of_view() -> None:
    lost = view((True, 10), (False, 21), (True, 40))
    assert following.episode_length_steps(lost, RATE_HZ) == 30
    assert not following.survives(lost, RATE_HZ)
    short = view((True, 10), (False, 20), (True, 40))
    assert following.episode_length_steps(short, RATE_HZ) == len(short) - 1
    assert following.survives(short, RATE_HZ)


def test_what_comes_after_the_first_steps_does_not_count_for_survival() -> None:
    late = view((True, 51), (False, 30))
    assert following.survives(late, RATE_HZ, steps=50)
    assert following.survives(late, RATE_HZ, steps=70)
    assert not following.survives(late, RATE_HZ, steps=71)


@given(IN_VIEW_OR_NOT)
def test_who_never_loses_it_has_the_longest_episode(in_view: np.ndarray) -> None:
    steps = following.episode_length_steps(in_view, RATE_HZ)
    assert 0 < steps <= len(in_view) - 1
    assert following.survives(in_view, RATE_HZ, steps - 1)
    if following.survives(in_view, RATE_HZ, len(in_view)):
        assert steps == len(in_view) - 1


def test_following_a_person_is_to_face_him_from_near() -> None:
    facing = np.array([True, True, False, True, True])
    near = following.person_following(facing, np.array([2.0, 2.0, 2.0, 3.5, 3.0]))
    assert (near.success, near.tracking_rate, near.collision) == (True, 0.5, False)
    assert not following.person_following(facing, np.array([2.0, 2.0, 2.0, 2.0, 3.1])).success
    assert not following.person_following(~facing, np.full(5, 2.0)).success


def test_a_collision_ends_it() -> None:
    hit = following.person_following(np.ones(5, dtype=bool), np.array([2.0, 2.0, 0.4, 2.0, 2.0]))
    assert (hit.success, hit.tracking_rate, hit.collision) == (False, 0.25, True)


@pytest.mark.parametrize(
    ("far_steps", "between_m", "success", "rate"),
    [
        (20, None, True, 40 / 60),
        (21, None, False, 9 / 60),
        # Somewhat nearer is not following yet, so that the count continues; following resets it.
        (21, 3.5, False, 9 / 60),
        (21, 2.0, True, 39 / 60),
    ],
)
def test_a_person_who_was_far_for_long_stays_lost(
    far_steps: int, between_m: float | None, success: bool, rate: float
) -> None:
    distance_m = np.full(61, 2.0)
    distance_m[10 : 10 + far_steps] = 4.5
    if between_m is not None:
        distance_m[20] = between_m
        distance_m[10 + far_steps] = 4.5
    came = following.person_following(np.ones(61, dtype=bool), distance_m)
    assert (came.success, came.tracking_rate) == (success, pytest.approx(rate))
