"""Controllers of a pan-tilt-zoom head: ``centre`` turns towards the estimate, ``lead`` to where the target will be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.kernels.records import record_kernel
from trackers.registry import tunable
from trackers.types import HEAD_COMMANDS

ZOOM, NOTHING, TILT, PAN = range(4)
"""Numbers of a command, see ``HEAD_COMMANDS``."""


@dataclass(frozen=True)
class CentreHeadParameters:
    """Settings.

    Attributes:
        gain_per_s: turn rate per radian of the estimate's angle from the optical axis.
    """

    gain_per_s: float = tunable(4.0, 0.5, 15.0, log=True)


@record_kernel()
def turn_to_estimate(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), as ``CentreHeadController`` defines them; see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``CentreHeadParameters``.
    """
    gain = parameters[0].gain_per_s
    for k in range(len(beliefs)):
        b = beliefs[k]
        out[k, ZOOM] = out[k, NOTHING] = out[k, TILT] = out[k, PAN] = 0.0
        if b.known > 0.0:
            reach_m = np.hypot(np.hypot(b.axis_ahead_m, b.axis_right_m), b.height_m)
            out[k, TILT] = -gain * np.arctan(b.picture_y * b.half_ahead_m / reach_m)
            out[k, PAN] = -gain * np.arctan(b.picture_x * b.half_right_m / reach_m)


@register_controller("centre_as_written", role="variant", carrier="tank-head", summary="with its gain not tuned")
@register_controller("centre", role="baseline", carrier="tank-head", summary="turns towards the estimate")
@register_controller("centre_as_written", role="variant", carrier="harbour-head", summary="with its gain not tuned")
@register_controller("centre", role="baseline", carrier="harbour-head", summary="turns towards the estimate")
@register_controller("centre", role="baseline", carrier="tank-ptz", summary="turns towards the estimate")
@register_controller("centre", role="baseline", carrier="harbour-ptz", summary="turns towards the estimate")
class CentreHeadController(KernelController):
    """Turns in proportion to the estimate's angles from the optical axis, right and down; does not zoom.

    Without an estimate (NaN) the head stays.
    """

    Parameters = CentreHeadParameters
    LOOKS, COMMANDS = "around", HEAD_COMMANDS
    KERNEL = Kernel(turn_to_estimate, record_dtype(CentreHeadParameters))


@dataclass(frozen=True)
class LeadHeadParameters:
    """Settings.

    Attributes:
        gain_per_s: turn rate per radian between the optical axis and the goal.
        lead_s: the goal is where the target will be after this time.
        patience_s: time constant of the decay of the target's velocity while no estimate comes.
        margin: half the picture's width, as a multiple of one standard deviation of the posterior and the distance
            that the target swims in ``lead_s``, to which the head zooms.
        zoom_gain_per_s: rate of zoom per unit of the zoom's logarithm.
    """

    gain_per_s: float = tunable(8.0, 0.5, 15.0, log=True)
    lead_s: float = tunable(0.1, 0.0, 0.5)
    patience_s: float = tunable(0.5, 0.05, 4.0, log=True)
    margin: float = tunable(12.0, 2.0, 40.0, log=True)
    zoom_gain_per_s: float = tunable(1.0, 0.0, 4.0)


LEAD_MEMORY = np.dtype([("has_known", "f8")], align=True)
"""1 once the tracker has answered."""


@record_kernel()
def turn_ahead(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), as ``LeadHeadController`` defines them; see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``LeadHeadParameters``. memory: (B,) records of ``LEAD_MEMORY``.
    """
    p = parameters[0]
    for k in range(len(beliefs)):
        b = beliefs[k]
        out[k, ZOOM] = out[k, NOTHING] = out[k, TILT] = out[k, PAN] = 0.0
        memory[k].has_known = max(memory[k].has_known, b.known)
        if memory[k].has_known == 0.0:
            continue
        waited_s = 0.0 if b.known > 0.0 else b.seconds_since_seen
        # The distance that the target covers while its velocity decays.
        ahead_s = p.lead_s + p.patience_s * (1.0 - np.exp(-waited_s / p.patience_s))
        goal_ahead_m = b.ahead_m + ahead_s * b.velocity_ahead_mps
        goal_right_m = b.right_m + ahead_s * b.velocity_right_mps
        axis_m, goal_m = np.hypot(b.axis_ahead_m, b.axis_right_m), np.hypot(goal_ahead_m, goal_right_m)
        out[k, TILT] = p.gain_per_s * (np.arctan2(b.height_m, axis_m) - np.arctan2(b.height_m, goal_m))
        out[k, PAN] = p.gain_per_s * np.arctan2(-goal_right_m, goal_ahead_m)
        out[k, ZOOM] = -p.zoom_gain_per_s
        if b.known > 0.0:
            speed_mps = np.hypot(b.velocity_ahead_mps, b.velocity_right_mps)
            wanted_m = p.margin * (b.spread_m + speed_mps * p.lead_s) + 1e-6
            out[k, ZOOM] = p.zoom_gain_per_s * np.log(b.half_right_m / wanted_m)


@register_controller(
    "lead", role="ours", carrier="tank-head", summary="turns to where the target will be, zooms out when it is unsure"
)
@register_controller(
    "lead",
    role="ours",
    carrier="harbour-head",
    summary="turns to where the target will be, zooms out when it is unsure",
)
class LeadHeadController(KernelController):
    """Turns towards the predicted place, by the belief's position and velocity on the ground.

    With the goal ``g = x + v lead_s`` ahead and right of the head at height ``h``::

        pan  = gain_per_s atan2(-g_right, g_ahead)
        tilt = gain_per_s (atan2(h, axis) - atan2(h, |g|))
        zoom = zoom_gain_per_s log(half width of the picture / (margin (spread + |v| lead_s)))

    Without an estimate ``x`` goes on with ``v``, which decays, and the head zooms out.
    """

    Parameters = LeadHeadParameters
    LOOKS, COMMANDS = "around", HEAD_COMMANDS
    KERNEL = Kernel(turn_ahead, record_dtype(LeadHeadParameters), LEAD_MEMORY)
