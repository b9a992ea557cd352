"""The belief about a target, updated from frame to frame: records, many at a time.

A *sighting* is a tracker's estimate on one picture, on the ground; a *belief* is filtered from all sightings so far.
World is the carrier's navigation frame (metres, x and y on the ground); *ahead* and *right* are horizontal, along and
across the carrier's heading, from the carrier.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.records import record_kernel

SECTORS = 8
"""Directions around the point where the target was last seen, counter-clockwise from world x."""
TRAIL = 20
"""Largest number of points of the target's trail."""
TRAIL_STEP_M = 0.4

SIGHTING = np.dtype(
    [
        ("carrier_x_m", "f8"),
        ("carrier_y_m", "f8"),
        ("height_m", "f8"),
        ("heading_rad", "f8"),
        # Where the optical axis meets the ground; a fixed distance ahead of a camera that looks ahead.
        ("axis_ahead_m", "f8"),
        ("axis_right_m", "f8"),
        # Half the picture on the ground, see ``features``; at a distance of 1 m for a camera that looks ahead.
        ("half_ahead_m", "f8"),
        ("half_right_m", "f8"),
        # 1 if there is an estimate, else 0: then the fields of the target have no meaning.
        ("known", "f8"),
        ("x_m", "f8"),
        ("y_m", "f8"),
        # Standard deviation, root mean square of both axes; 0 without a posterior.
        ("spread_m", "f8"),
        # Centre of the picture-sized window that holds most of the posterior, and the share in it.
        ("densest_x_m", "f8"),
        ("densest_y_m", "f8"),
        ("densest_share", "f8"),
        # If the tracker gives none: 1 if its estimate lies in the picture, else 0.
        ("in_view_probability", "f8"),
        # From the picture's centre, right and down, in halves of its width and height.
        ("picture_x", "f8"),
        ("picture_y", "f8"),
        # Longer side of the box over the picture's width; 0 without a box.
        ("length_share", "f8"),
        # Distance along the camera's axis: of the estimate, as measured or on the ground, and of the axis' point there.
        # Other than x and y they have no limit on the ground, and are infinite at or above the horizon.
        ("depth_m", "f8"),
        ("axis_depth_m", "f8"),
    ],
    align=True,
)

BELIEF = np.dtype(
    [
        ("frames", "f8"),
        ("carrier_x_m", "f8"),
        ("carrier_y_m", "f8"),
        ("heading_rad", "f8"),
        ("height_m", "f8"),
        ("own_ahead_mps", "f8"),
        ("own_right_mps", "f8"),
        ("own_climb_mps", "f8"),
        ("own_yaw_rate_rad_s", "f8"),
        ("axis_ahead_m", "f8"),
        ("axis_right_m", "f8"),
        ("axis_ahead_mps", "f8"),
        ("axis_right_mps", "f8"),
        ("half_ahead_m", "f8"),
        ("half_right_m", "f8"),
        # See ``mount_slope``; without meaning for a camera that looks ahead.
        ("mount_slope", "f8"),
        ("known", "f8"),
        ("x_m", "f8"),
        ("y_m", "f8"),
        ("velocity_x_mps", "f8"),
        ("velocity_y_mps", "f8"),
        ("ahead_m", "f8"),
        ("right_m", "f8"),
        ("velocity_ahead_mps", "f8"),
        ("velocity_right_mps", "f8"),
        ("spread_m", "f8"),
        ("densest_ahead_m", "f8"),
        ("densest_right_m", "f8"),
        ("densest_share", "f8"),
        ("in_view_probability", "f8"),
        ("picture_x", "f8"),
        ("picture_y", "f8"),
        ("length_share", "f8"),
        ("depth_m", "f8"),
        ("axis_depth_m", "f8"),
        ("seconds_since_seen", "f8"),
        ("seen_x_m", "f8"),
        ("seen_y_m", "f8"),
        # 1 for a direction from the point last seen that the camera has just searched in vain; decays with time.
        ("searched", "f8", (SECTORS,)),
        # Points where the target was seen, ``TRAIL_STEP_M`` apart, the latest first.
        ("trail_places", "f8"),
        ("trail_x_m", "f8", (TRAIL,)),
        ("trail_y_m", "f8", (TRAIL,)),
    ],
    align=True,
)

SEEN_PROBABILITY = 0.5
"""Least in-view probability at which a target counts as seen."""
_VELOCITY_SHARE = 0.12
"""Gain of the velocity's alpha-beta filter; the position is the tracker's, which is filtered already."""
_OWN_SHARE = 0.3
"""Gain of the exponential smoothing of the carrier's measured velocities."""
_FORGET_S = 4.0
"""Time constant of ``searched``."""
_LOOKED_AWAY = 0.4
"""A direction is searched if the optical axis is this far from the point last seen, in halves of the picture."""
_FASTEST_MPS = 30.0


@record_kernel()
def update_beliefs(beliefs: NDArray[np.void], sightings: NDArray[np.void], interval_s: float) -> None:
    """Update B beliefs (B,) of dtype ``BELIEF`` with a sighting each (B,) of dtype ``SIGHTING``, in place.

    A belief of zeros is initialised by its first sighting.
    """
    for k in range(len(beliefs)):
        b, s = beliefs[k], sightings[k]
        c, d = np.cos(s.heading_rad), np.sin(s.heading_rad)
        if b.frames == 0.0:
            b.carrier_x_m, b.carrier_y_m = s.carrier_x_m, s.carrier_y_m
            b.height_m, b.heading_rad = s.height_m, s.heading_rad
            b.axis_ahead_m, b.axis_right_m = s.axis_ahead_m, s.axis_right_m
            b.mount_slope = mount_slope(s.axis_ahead_m, s.height_m, s.half_ahead_m)
            b.x_m, b.y_m, b.seen_x_m, b.seen_y_m = s.x_m, s.y_m, s.x_m, s.y_m
        _own_motion(b, s, c, d, interval_s)
        _target_motion(b, s, interval_s)
        east_m, north_m = b.x_m - s.carrier_x_m, b.y_m - s.carrier_y_m
        b.ahead_m, b.right_m = c * east_m + d * north_m, d * east_m - c * north_m
        b.velocity_ahead_mps = c * b.velocity_x_mps + d * b.velocity_y_mps
        b.velocity_right_mps = d * b.velocity_x_mps - c * b.velocity_y_mps
        if s.known > 0.0:
            east_m, north_m = s.densest_x_m - s.carrier_x_m, s.densest_y_m - s.carrier_y_m
            b.densest_share, b.spread_m = s.densest_share, s.spread_m
            b.picture_x, b.picture_y, b.length_share = s.picture_x, s.picture_y, s.length_share
            b.depth_m = s.depth_m
            b.densest_ahead_m, b.densest_right_m = c * east_m + d * north_m, d * east_m - c * north_m
        b.known, b.in_view_probability = s.known, s.in_view_probability * s.known
        _search(b, s, c, d, interval_s)
        b.frames += 1.0


@record_kernel()
def mount_slope(axis_ahead_m: float, height_m: float, half_ahead_m: float) -> float:
    """Return the tangent of the angle at which a camera is mounted, forward from straight down, by its first picture.

    0 if the point below the camera is in the picture's height: then it looks straight down but for the air.
    """
    return axis_ahead_m / max(height_m, 1.0) if axis_ahead_m > half_ahead_m else 0.0


@record_kernel()
def _own_motion(b: Any, s: Any, c: float, d: float, interval_s: float) -> None:
    """Update the carrier's pose as measured; its velocities are smoothed differences."""
    east_m, north_m = s.carrier_x_m - b.carrier_x_m, s.carrier_y_m - b.carrier_y_m
    turn_rad = (s.heading_rad - b.heading_rad + np.pi) % (2 * np.pi) - np.pi
    share = _OWN_SHARE if b.frames > 0.0 else 0.0
    b.own_ahead_mps += share * ((c * east_m + d * north_m) / interval_s - b.own_ahead_mps)
    b.own_right_mps += share * ((d * east_m - c * north_m) / interval_s - b.own_right_mps)
    b.own_climb_mps += share * ((s.height_m - b.height_m) / interval_s - b.own_climb_mps)
    b.own_yaw_rate_rad_s += share * (turn_rad / interval_s - b.own_yaw_rate_rad_s)
    b.axis_ahead_mps += share * ((s.axis_ahead_m - b.axis_ahead_m) / interval_s - b.axis_ahead_mps)
    b.axis_right_mps += share * ((s.axis_right_m - b.axis_right_m) / interval_s - b.axis_right_mps)
    b.carrier_x_m, b.carrier_y_m = s.carrier_x_m, s.carrier_y_m
    b.height_m, b.heading_rad = s.height_m, s.heading_rad
    b.axis_ahead_m, b.axis_right_m = s.axis_ahead_m, s.axis_right_m
    b.half_ahead_m, b.half_right_m, b.axis_depth_m = s.half_ahead_m, s.half_right_m, s.axis_depth_m


@record_kernel()
def _target_motion(b: Any, s: Any, interval_s: float) -> None:
    """Update the target's position and velocity by an alpha-beta filter; without an estimate both stay."""
    if s.known == 0.0:
        return
    if b.frames == 0.0:
        b.x_m, b.y_m = s.x_m, s.y_m
        return
    # The velocity does not follow a jump of the estimate, nor the change over a gap in the estimates.
    east_m, north_m = s.x_m - b.x_m - b.velocity_x_mps * interval_s, s.y_m - b.y_m - b.velocity_y_mps * interval_s
    share = _VELOCITY_SHARE / interval_s
    if b.known > 0.0 and np.hypot(east_m, north_m) < _FASTEST_MPS * interval_s:
        b.velocity_x_mps += share * east_m
        b.velocity_y_mps += share * north_m
    b.x_m, b.y_m = s.x_m, s.y_m


@record_kernel()
def _search(b: Any, s: Any, c: float, d: float, interval_s: float) -> None:
    """Update the time since the target was seen, and the directions from there searched since."""
    if s.known > 0.0 and s.in_view_probability >= SEEN_PROBABILITY:
        b.seconds_since_seen = 0.0
        b.seen_x_m, b.seen_y_m = s.x_m, s.y_m
        for sector in range(SECTORS):
            b.searched[sector] = 0.0
        _trail(b)
        return
    b.seconds_since_seen += interval_s
    kept = np.exp(-interval_s / _FORGET_S)
    for sector in range(SECTORS):
        b.searched[sector] *= kept
    east_m = s.carrier_x_m + c * s.axis_ahead_m + d * s.axis_right_m - b.seen_x_m
    north_m = s.carrier_y_m + d * s.axis_ahead_m - c * s.axis_right_m - b.seen_y_m
    if np.hypot(east_m, north_m) > _LOOKED_AWAY * s.half_right_m:
        sector = int(np.floor(np.arctan2(north_m, east_m) / (2 * np.pi) * SECTORS + 0.5)) % SECTORS
        b.searched[sector] = 1.0


@record_kernel()
def _trail(b: Any) -> None:
    """Add the target's position to its trail if it is far enough from the latest point."""
    known = int(b.trail_places)
    if known > 0 and np.hypot(b.seen_x_m - b.trail_x_m[0], b.seen_y_m - b.trail_y_m[0]) < TRAIL_STEP_M:
        return
    for place in range(min(known, TRAIL - 1), 0, -1):
        b.trail_x_m[place], b.trail_y_m[place] = b.trail_x_m[place - 1], b.trail_y_m[place - 1]
    b.trail_x_m[0], b.trail_y_m[0] = b.seen_x_m, b.seen_y_m
    b.trail_places = min(known + 1, TRAIL)


@record_kernel()
def densest_window(
    places_m: NDArray[np.float64], weights: NDArray[np.float64], half_m: float, tries: int
) -> tuple[float, float, float]:
    """Return the centre (x, y) of the circle that holds most of a posterior, and the share in it.

    Args:
        places_m: (N, 2) particles. weights: (N,) sum 1. half_m: radius.
        tries: circles tried, around evenly chosen particles; the best one is moved to the mean of its particles.
    """
    stride = max(len(places_m) // tries, 1)
    centres_x, centres_y = places_m[::stride, 0].copy(), places_m[::stride, 1].copy()
    shares, sums_x, sums_y = np.zeros_like(centres_x), np.zeros_like(centres_x), np.zeros_like(centres_x)
    # All circles at once, so that this becomes vector code.
    for n in range(len(places_m)):
        x, y, weight = places_m[n, 0], places_m[n, 1], weights[n]
        for k in range(len(shares)):
            held = weight if (x - centres_x[k]) ** 2 + (y - centres_y[k]) ** 2 <= half_m * half_m else 0.0
            shares[k] += held
            sums_x[k] += held * x
            sums_y[k] += held * y
    best, best_x, best_y = -1.0, places_m[0, 0], places_m[0, 1]
    for k in range(len(shares)):
        if shares[k] > best:
            best = shares[k]
            best_x, best_y = centres_x[k], centres_y[k]
            if best > 0.0:
                best_x, best_y = sums_x[k] / best, sums_y[k] / best
    return best_x, best_y, _share_within(places_m, weights, half_m, best_x, best_y)


@record_kernel()
def _share_within(
    places_m: NDArray[np.float64], weights: NDArray[np.float64], half_m: float, x_m: float, y_m: float
) -> float:
    """Return the share of a posterior within ``half_m`` of a point."""
    share = 0.0
    for n in range(len(places_m)):
        if (places_m[n, 0] - x_m) ** 2 + (places_m[n, 1] - y_m) ** 2 <= half_m * half_m:
            share += weights[n]
    return share
