"""The command of an action in each mode."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.envs.actions import action_count, steering
from scenarios.envs.settings import FollowSettings
from scenarios.road_town.flight import HELICOPTER
from scenarios.stereo_follow.robot import ROBOT
from trackers.controllers.catalogue import controller_entry
from trackers.types import CameraCommand, CameraModel, EgoPose, Estimate, Observation

SHARES = st.floats(-1, 1)


class Counting:
    """A controller that counts its calls."""

    def __init__(self) -> None:
        self.asked = 0

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        self.asked += 1
        return CameraCommand(forward_mps=float(self.asked))


class Constant:
    """A controller with a constant command."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        return CameraCommand(forward_mps=20.0, climb_mps=-1.0)


def settings(**changes: Any) -> FollowSettings:
    return FollowSettings("road-town-v2", "hold", **changes)


TOWN = settings()
"""Made before the clock of a test runs: it imports the trackers, which takes seconds."""


def latest(probability: float = 0.9) -> tuple[Observation, Estimate]:
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[2, 3] = 50.0
    observation = Observation(np.zeros((48, 64, 3), np.uint8), 0.0, CameraModel(64, 48, 70.0), ego=EgoPose(T))
    return observation, Estimate(np.array([40.0, 20.0]), in_view_probability=probability)


@given(SHARES, SHARES, SHARES, SHARES)
def test_a_command_is_an_action_times_its_limits(a: float, b: float, c: float, d: float) -> None:
    command = steering(TOWN, HELICOPTER)(np.array([a, b, c, d]), *latest())
    assert command == CameraCommand(25.0 * a, 25.0 * b, 5.0 * c, 1.0 * d)


def test_the_robot_takes_two_numbers() -> None:
    assert action_count(FollowSettings("stereo-follow-v2", "hold"), ROBOT) == 2
    stereo = steering(FollowSettings("stereo-follow-v2", "hold"), ROBOT)
    assert stereo(np.array([1.0, -0.5]), *latest()) == CameraCommand(forward_mps=1.6, yaw_rate_rad_s=-0.8)


def test_a_correction_is_added_within_the_limits() -> None:
    correcting = steering(settings(action="correction", controller=Constant(), correction_share=0.5), HELICOPTER)
    assert correcting(np.zeros(4), *latest()) == CameraCommand(forward_mps=20.0, climb_mps=-1.0)
    got = correcting(np.array([1.0, -1.0, 0.2, 0.0]), *latest())
    assert got == CameraCommand(25.0, -12.5, pytest.approx(-0.5), 0.0)


def test_a_controller_carries_nothing_from_one_episode_to_the_next() -> None:
    mine = Counting()
    setting = settings(action="correction", controller=mine)
    for _ in range(2):
        episode = steering(setting, HELICOPTER)
        assert [episode(np.zeros(4), *latest()).forward_mps for _ in range(3)] == [1.0, 2.0, 3.0]
    assert mine.asked == 0


def test_no_correction_is_the_controllers_own_command_to_the_last_bit() -> None:
    class Odd(Constant):
        def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
            return CameraCommand(forward_mps=0.1 + 0.2, climb_mps=1 / 3)

    odd = steering(settings(action="correction", controller=Odd()), HELICOPTER)
    assert odd(np.zeros(4), *latest()) == CameraCommand(forward_mps=0.1 + 0.2, climb_mps=1 / 3)


def test_a_correction_may_be_for_the_unseen_alone() -> None:
    correcting = steering(settings(action="correction", controller=Constant(), corrects="unseen"), HELICOPTER)
    assert correcting(np.ones(4), *latest(0.9)).climb_mps == -1.0
    assert correcting(np.ones(4), *latest(0.1)).climb_mps > 0.0
    observation, _ = latest()
    assert correcting(np.ones(4), observation, Estimate(np.full(2, np.nan))).climb_mps > 0.0


def test_parameters_span_their_ranges() -> None:
    setting = settings(action="parameters", controller="centre")
    fields = controller_entry("centre", "helicopter").tunables()
    assert action_count(setting, HELICOPTER) == len(fields)
    mode = steering(setting, HELICOPTER)
    for share, end in ((-1.0, "low"), (1.0, "high")):
        mode(np.full(len(fields), share), *latest())
        values = dataclasses.asdict(mode.args[0].parameters)  # type: ignore[attr-defined]
        for name, field in fields.items():
            assert values[name] == pytest.approx(field.metadata[end])
    mode(np.zeros(len(fields)), *latest())
    gain = fields["gain_per_s"].metadata
    # The middle of a logarithmic range is the geometric mean.
    assert mode.args[0].parameters.gain_per_s == pytest.approx((gain["low"] * gain["high"]) ** 0.5)  # type: ignore[attr-defined]


def test_what_is_no_command_is_named() -> None:
    class Pair:
        def command(self, observation: Observation, estimate: Estimate) -> Any:
            return 1.0, 2.0

    mode = steering(settings(action="correction", controller=Pair()), HELICOPTER)
    with pytest.raises(ValueError, match="command: expected a CameraCommand, got tuple"):
        mode(np.ones(4), *latest())


def test_modes_that_need_a_controller_with_parameters_say_so() -> None:
    with pytest.raises(ValueError, match="controller: expected one with parameters to set"):
        action_count(settings(action="parameters", controller="hold"), HELICOPTER)
    with pytest.raises(ValueError, match="controller: expected the name of a controller"):
        action_count(settings(action="parameters", controller=Constant()), HELICOPTER)
    for values, told in (
        ({"wheels": 3}, "controller_values: centre: expected parameters among .*, got 'wheels'"),
        ({"gain_per_s": "x"}, "controller_values: centre: expected a number for gain_per_s, got 'x'"),
    ):
        for action in ("correction", "parameters"):
            with pytest.raises(ValueError, match=told):
                action_count(settings(action=action, controller="centre", controller_values=values), HELICOPTER)
    with pytest.raises(ValueError, match="got 'chase'"):
        action_count(settings(action="correction", controller="chase"), HELICOPTER)
    with pytest.raises(ValueError, match="got 'chase'"):
        steering(settings(action="correction", controller="chase"), HELICOPTER)
