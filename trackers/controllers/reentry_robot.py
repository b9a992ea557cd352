"""Our controller of a ground robot: steers by the belief and searches for a lost target along its path."""

from __future__ import annotations

from dataclasses import dataclass

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.controllers.reentry_robot_kernel import steer_robot
from trackers.registry import tunable


@dataclass(frozen=True)
class ReentryRobotParameters:
    """Settings.

    Attributes:
        turn_gain_per_s: turn rate per radian of bearing.
        turn_lead_s: prediction time of the target's bearing.
        turn_feed_forward: share of the line of sight's turn rate that is added to the turn rate.
        speed_gain_per_s: speed per metre that the target is too far away.
        speed_feed_forward: share of the target's speed away from the robot that is added to the speed.
        distance_m: distance to keep.
        stray_mps: assumed sideways speed of a target out of view; the robot keeps far enough away to have all its
            possible positions in the picture.
        patience_s: time without an estimate during which the target's motion is extrapolated.
        carrot_m: look-ahead distance on the target's trail (pure pursuit).
        trail_share: how far the robot steers to the trail while the straight path is free; 0: not at all.
        aside_rad: largest angle between the course and the target's bearing; half the picture is 0.58.
        onward_s: time by which the search extrapolates the target's motion from the point last seen.
        reached_m: distance to that point at which the robot looks around.
        look_rad_s: turn rate while looking around.
        ahead_rather: weight of the target's direction of travel when looking around; 0: none.
        turn_cost: weight of each radian to turn when looking around.
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
)
class ReentryRobotController(KernelController):
    """Steers by ``steer_robot``; the belief's trail of the target needs measured poses (odometry)."""

    Parameters = ReentryRobotParameters
    LOOKS, KERNEL = "ahead", Kernel(steer_robot, record_dtype(ReentryRobotParameters))
