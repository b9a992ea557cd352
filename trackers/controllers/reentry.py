"""Our controller of a helicopter: keeps the target in view in gusts and flies to where it will re-enter the view."""

from __future__ import annotations

from dataclasses import dataclass

from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.controllers.reentry_kernel import steer
from trackers.registry import tunable


@dataclass(frozen=True)
class ReentryParameters:
    """Settings. The *goal* is the point on the ground over which the target is to be kept, see ``ReentryController``.

    Attributes:
        gain_per_s: velocity per metre of the target's offset from the goal.
        urgent_per_s: additional velocity per metre that the target lies outside the picture.
        push_s: lead that compensates the carrier's lag: seconds of the commanded acceleration.
        gust_lead_s: time by which a swing of the optical axis is extrapolated.
        lean: share of the optical axis' swing by which the goal moves; 0 keeps it below the camera.
        damping: share of the target's velocity relative to the goal that is added to the command.
        border: margin inside the picture's border that does not count as in view, a share of the half sizes.
        rest: dead zone: offsets from the goal below this, in halves of the picture, have no effect.
        height_m: height above ground while the target's position is known.
        sink_mps: largest sink rate.
        doubt: the target is lost if the posterior is wider than this, in halves of the picture's height on the ground.
        patience_s: without a posterior the target is lost after this time out of view.
        search_mps: speed at which the search without a posterior moves outwards.
        fastest_mps: limit of the velocity's magnitude.
        turn_per_s: turn rate per radian of the target's bearing; of a camera that is pitched forward alone.
    """

    gain_per_s: float = tunable(1.0, 0.2, 8.0, log=True)
    urgent_per_s: float = tunable(1.0, 0.0, 8.0)
    push_s: float = tunable(0.45, 0.0, 2.0)
    gust_lead_s: float = tunable(0.45, 0.0, 1.5)
    lean: float = tunable(0.45, 0.0, 0.7)
    damping: float = tunable(0.25, 0.0, 0.8)
    border: float = tunable(0.14, 0.05, 0.5)
    rest: float = tunable(0.05, 0.0, 0.5)
    height_m: float = tunable(40.0, 40.0, 65.0)
    sink_mps: float = tunable(4.0, 0.5, 5.0)
    doubt: float = 0.4
    patience_s: float = 1.5
    search_mps: float = 6.0
    fastest_mps: float = 25.0
    turn_per_s: float = 2.0


@register_controller(
    "reentry",
    role="ours",
    carrier="helicopter",
    summary="keeps the target in view, or flies to where it will come back",
)
class ReentryController(KernelController):
    """Flies only as far as needed to keep the target in view, during a gust and after it.

    All points are on the ground, ahead and right of the point below the camera. With the belief's position ``x`` and
    velocity ``v`` of the target, the own velocity ``u``, the picture without its border ``Q``, and the optical axis
    ``a``::

        a' = a + gust_lead_s (da/dt along a)
        g  = the point in Q(a') nearest to lean a', itself clipped to Q(0): the goal
        e  = x - g, shortened by the dead zone ``rest``
        s  = the point in Q(a') nearest to x
        w  = v + gain_per_s e + urgent_per_s (x - s) + damping (v - u - lean da/dt)
        command = w + push_s (w - u), no faster than fastest_mps

    In still air ``g`` is about the point below the camera. When a gust tilts the camera, ``g`` moves part of the way
    with the view: into the tilted picture and still inside the level one, so the target is in view during the gust and
    after it. At a lower height the same tilt needs a shorter flight, so the helicopter sinks.

    A target is lost when its posterior is wider than ``doubt``. Then ``x`` is the centre of the posterior's densest
    window (the tracker has already discounted areas searched in vain), ``v`` decays, and the helicopter climbs until
    the picture is as large as the posterior. Without a posterior the search moves outwards from the point last seen,
    first in the target's direction of travel, then in directions not yet searched.

    Under a camera that is pitched forward (``mount_slope``) "below the camera" means where its axis meets the ground in
    still air, and the nose turns to the target.
    """

    Parameters = ReentryParameters
    LOOKS, KERNEL = "down", Kernel(steer, record_dtype(ReentryParameters))
