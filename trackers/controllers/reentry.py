"""Our controller of a helicopter: keeps the target in view in gusts and flies to where it will re-enter the view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import SECTORS
from trackers.controllers.catalogue import Kernel, register_controller
from trackers.controllers.kernel_controller import KernelController, record_dtype
from trackers.kernels.records import record_kernel
from trackers.registry import tunable

_STRONGEST_GUST = 0.7
"""Tangent of the tilt up to which the optical axis is extrapolated."""
_HEIGHT_SLACK_M = 1.5
"""Dead zone of the height: with biased instruments the exact height is never reached."""
_HIGHEST_M, _CLIMB_MPS = 90.0, 5.0
_SHALLOWEST = 0.1
"""Least cosine of an angle from the optical axis or from straight down; larger angles are clipped."""


@record_kernel()
def steer(
    beliefs: NDArray[np.void],
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the commands of B beliefs (B,), each from the belief alone; see ``catalogue.Kernel``.

    Args:
        parameters: (1,) record of ``ReentryParameters``. The equations are in ``ReentryController``.
    """
    p = parameters[0]
    for k in range(len(beliefs)):
        b = beliefs[k]
        aim_ahead_m, aim_right_m, moving = aim_point(b, p)
        velocity_ahead_mps, velocity_right_mps = moving * b.velocity_ahead_mps, moving * b.velocity_right_mps
        pull_ahead_mps, pull_right_mps = _pull(b, p, aim_ahead_m, aim_right_m, velocity_ahead_mps, velocity_right_mps)
        ahead_mps, right_mps = velocity_ahead_mps + pull_ahead_mps, velocity_right_mps + pull_right_mps
        # Lead for the carrier's lag.
        ahead_mps += p.push_s * (ahead_mps - b.own_ahead_mps)
        right_mps += p.push_s * (right_mps - b.own_right_mps)
        slower = min(1.0, p.fastest_mps / max(np.hypot(ahead_mps, right_mps), 1e-9))
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = slower * ahead_mps, slower * right_mps, climb_rate(b, p), 0.0
        if b.mount_slope > 0.0:
            out[k, 3] = turn_rate(b, p, aim_ahead_m, aim_right_m)


@record_kernel()
def _is_lost(b: Any, p: Any) -> bool:
    """Return whether the target is lost: a wide posterior, or none and the target out of view for long."""
    if b.known > 0.0 and b.spread_m > 0.0:
        return b.spread_m > p.doubt * b.half_ahead_m
    return b.seconds_since_seen > p.patience_s


@record_kernel()
def aim_point(b: Any, p: Any) -> tuple[float, float, float]:
    """Return the point to bring into view (ahead, right) and the share of the target's velocity at which it moves."""
    if not _is_lost(b, p):
        return b.ahead_m, b.right_m, 1.0
    moving = np.exp(-b.seconds_since_seen / max(p.patience_s, 1e-3))
    if b.known > 0.0 and b.spread_m > 0.0:
        return b.densest_ahead_m, b.densest_right_m, moving
    # Without a posterior: outwards from the point last seen, preferably in its direction of travel, unsearched first.
    course_rad = np.arctan2(b.velocity_y_mps, b.velocity_x_mps)
    best, best_rad = -np.inf, course_rad
    for sector in range(SECTORS):
        angle_rad = 2 * np.pi * sector / SECTORS
        worth = np.cos(angle_rad - course_rad) - 4.0 * b.searched[sector]
        if worth > best:
            best, best_rad = worth, angle_rad
    reach_m = p.search_mps * (b.seconds_since_seen - p.patience_s)
    east_m = b.seen_x_m + reach_m * np.cos(best_rad) - b.carrier_x_m
    north_m = b.seen_y_m + reach_m * np.sin(best_rad) - b.carrier_y_m
    c, s = np.cos(b.heading_rad), np.sin(b.heading_rad)
    return c * east_m + s * north_m, s * east_m - c * north_m, 0.0


@record_kernel()
def _pull(
    b: Any, p: Any, ahead_m: float, right_m: float, velocity_ahead_mps: float, velocity_right_mps: float
) -> tuple[float, float]:
    """Return the velocity relative to the target's that brings a point on the ground to the goal."""
    height_m = max(b.height_m, 1.0)
    inner = 1.0 - p.border
    half_ahead, half_right = inner * b.half_ahead_m / height_m, inner * b.half_right_m / height_m
    axis_ahead, axis_right = _axis_soon(b, p, height_m)
    lean_ahead = b.mount_slope + min(max(p.lean * (axis_ahead - b.mount_slope), -half_ahead), half_ahead)
    lean_right = min(max(p.lean * axis_right, -half_right), half_right)
    goal_ahead, goal_right = nearest_seen(lean_ahead, lean_right, axis_ahead, axis_right, half_ahead, half_right)
    off_ahead_m, off_right_m = ahead_m - height_m * goal_ahead, right_m - height_m * goal_right
    off = np.hypot(off_ahead_m / max(b.half_ahead_m, 1e-3), off_right_m / max(b.half_right_m, 1e-3))
    gain_per_s = p.gain_per_s * max(0.0, 1.0 - p.rest / max(off, 1e-9))
    seen_ahead, seen_right = nearest_seen(
        ahead_m / height_m, right_m / height_m, axis_ahead, axis_right, half_ahead, half_right
    )
    return (
        gain_per_s * off_ahead_m
        + p.urgent_per_s * (ahead_m - height_m * seen_ahead)
        + p.damping * (velocity_ahead_mps - b.own_ahead_mps - p.lean * b.axis_ahead_mps),
        gain_per_s * off_right_m
        + p.urgent_per_s * (right_m - height_m * seen_right)
        + p.damping * (velocity_right_mps - b.own_right_mps - p.lean * b.axis_right_mps),
    )


@record_kernel()
def _axis_soon(b: Any, p: Any, height_m: float) -> tuple[float, float]:
    """Return where the extrapolated optical axis meets the ground (ahead, right), over the height."""
    ahead, right = b.axis_ahead_m / height_m - b.mount_slope, b.axis_right_m / height_m
    far = max(np.hypot(ahead, right), 1e-9)
    outwards_per_s = (ahead * b.axis_ahead_mps + right * b.axis_right_mps) / (far * height_m)
    soon = min(max(far + p.gust_lead_s * outwards_per_s, 0.0), max(_STRONGEST_GUST, far))
    return b.mount_slope + ahead * soon / far, right * soon / far


@record_kernel()
def climb_rate(b: Any, p: Any) -> float:
    """Return the climb rate to ``height_m``, or to the height at which the picture covers a lost target's posterior."""
    wanted_m = p.height_m
    if _is_lost(b, p):
        wanted_m = max(wanted_m, b.spread_m * b.height_m / max(b.half_ahead_m, 1e-3))
    off_m = min(wanted_m, _HIGHEST_M) - b.height_m
    if abs(off_m) < _HEIGHT_SLACK_M:
        return 0.0
    return min(max(off_m, -p.sink_mps), _CLIMB_MPS)


@record_kernel()
def turn_rate(b: Any, p: Any, ahead_m: float, right_m: float) -> float:
    """Return the turn rate of the nose to a point on the ground, under a camera that is pitched forward."""
    # A point nearly below has no bearing.
    return -p.turn_per_s * np.arctan2(right_m, max(ahead_m, 0.5 * b.mount_slope * b.height_m))


@record_kernel()
def nearest_seen(
    ahead: float, right: float, axis_ahead: float, axis_right: float, half_ahead: float, half_right: float
) -> tuple[float, float]:
    """Return the point on the ground (ahead, right) in a tilted camera's view nearest, in the picture, to a point.

    All lengths are over the height. ``axis_*``: where the optical axis meets the ground; ``half_*``: tangents of half
    the fields of view.
    """
    cp, sp, cr, sr = tilted_axes(axis_ahead, axis_right)
    _, up, aside = in_picture(ahead, right, cp, sp, cr, sr)
    up, aside = min(max(up, -half_ahead), half_ahead), min(max(aside, -half_right), half_right)
    # Back to the ground along the ray of the clipped pixel.
    down = max(cp * cr - up * sp + aside * cp * sr, _SHALLOWEST)
    return (sp * cr + up * cp + aside * sp * sr) / down, (aside * cr - sr) / down


@record_kernel()
def tilted_axes(axis_ahead: float, axis_right: float) -> tuple[float, float, float, float]:
    """Return cosine and sine of the pitch, and of the roll, of a camera whose optical axis meets the ground there."""
    pitch_rad = np.arctan(axis_ahead)
    cp, sp = np.cos(pitch_rad), np.sin(pitch_rad)
    roll_rad = np.arctan(-axis_right * cp)
    return cp, sp, np.cos(roll_rad), np.sin(roll_rad)


@record_kernel()
def in_picture(ahead: float, right: float, cp: float, sp: float, cr: float, sr: float) -> tuple[float, float, float]:
    """Return a point on the ground in the camera's axes: along the optical axis, and over that up and right."""
    depth = max(ahead * sp * cr - right * sr + cp * cr, _SHALLOWEST)
    return depth, (ahead * cp - sp) / depth, (ahead * sp * sr + right * cr + cp * sr) / depth


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
