"""Ours for a ground robot: it steers by what is believed of the target, and looks for it where it must be."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from trackers.belief.belief_filter import BeliefKeeper
from trackers.controllers.catalogue import register_controller
from trackers.controllers.reentry_robot_kernel import REENTRY_ROBOT, steer_robot
from trackers.registry import tunable
from trackers.types import CameraCommand, Estimate, Observation


@dataclass(frozen=True)
class ReentryRobotParameters:
    """Settings.

    Attributes:
        turn_gain_per_s: turn rate for each radian off the middle.
        turn_lead_s: it turns to where the target will be then.
        turn_feed_forward: share of the rate at which the line to the target turns that is turned along with it.
        speed_gain_per_s: speed for each metre too far away.
        speed_feed_forward: share of the target's speed away from the robot that is driven along with it.
        distance_m: how far away the target is wanted.
        stray_mps: how fast a target out of sight may leave its course to either side; the robot keeps so far off that
            it stays in the picture.
        patience_s: how long a target of which nothing is said counts as going on as it did.
        carrot_m: where it goes the target's way it steers for the place of it so far on.
        trail_share: how far it goes the target's own way where nothing bars the straight one; 0: not.
        aside_rad: how far aside of the target it looks for that; half the picture is 0.58.
        onward_s: how far, in time, beyond the place last seen it goes to look for the target.
        reached_m: how near that place is near enough to look around.
        look_rad_s: turn rate for looking around.
        ahead_rather: how much likelier the target is ahead, as it went, than elsewhere; 0: not.
        turn_cost: how much less a direction is worth for each radian to turn to it.
    """

    turn_gain_per_s: float = tunable(2.2, 0.5, 6.0, log=True)
    turn_lead_s: float = tunable(0.2, 0.0, 0.6)
    turn_feed_forward: float = tunable(0.5, 0.0, 1.0)
    speed_gain_per_s: float = tunable(1.1, 0.3, 3.0, log=True)
    speed_feed_forward: float = tunable(0.8, 0.0, 1.0)
    distance_m: float = tunable(2.2, 1.2, 3.0)
    stray_mps: float = tunable(0.5, 0.0, 1.0)
    patience_s: float = tunable(3.0, 0.0, 5.0)
    carrot_m: float = tunable(0.9, 0.5, 1.6)
    trail_share: float = tunable(0.3, 0.0, 1.0)
    aside_rad: float = tunable(0.35, 0.1, 0.5)
    onward_s: float = tunable(1.0, 0.0, 4.0)
    reached_m: float = tunable(0.6, 0.3, 1.5)
    look_rad_s: float = tunable(1.0, 0.4, 1.6)
    ahead_rather: float = tunable(0.5, 0.0, 1.5)
    turn_cost: float = tunable(0.5, 0.0, 1.5)


@register_controller(
    "reentry",
    role="ours",
    carrier="robot",
    summary="steers by the belief; looks to where the target must come back",
    kernel=(steer_robot, REENTRY_ROBOT),
)
class ReentryRobotController:
    """Keeps the belief and asks the law ``steer_robot`` about it; its memory of ways and places wants odometry."""

    Parameters = ReentryRobotParameters

    def __init__(self, parameters: ReentryRobotParameters) -> None:
        self.parameters = parameters
        self._keeper = BeliefKeeper("ahead")
        self._out = np.zeros((1, 4))

    @property
    def parameters(self) -> ReentryRobotParameters:
        """The setting; another may take its place between two pictures."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: ReentryRobotParameters) -> None:
        self._parameters = parameters
        self._record = np.array([dataclasses.astuple(parameters)], REENTRY_ROBOT)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command by all that the tracker has said so far."""
        steer_robot(self._keeper.update(observation, estimate), self._record, self._out)
        return CameraCommand(*(float(number) for number in self._out[0]))
