"""The road's shape: a cubic spline through points of its centre line, which move with the ground and are extended where
new road comes into view (paper A, section 3.1; A.2 steps 1-3).

All positions are in pixels from the image centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.paper_a.background_motion import Motion
from trackers.paper_a.road_lines import LineFinder, RoadEnd, RoadSearch
from trackers.paper_a.spline import evaluate_spline, fit_cubic_spline


@dataclass(frozen=True)
class RoadCurve:
    """The road as a function of one image axis: ``R = {S_1 ... S_{n-1}}`` (equations 3.1, 3.2).

    Attributes:
        axis: 0 if y = S(x), 1 if x = S(y); the axis nearer to the road's direction.
        knots: (n,) positions along the axis, increasing; pieces: (n - 1, 4).
        half_width_px: distance from the centre line to an edge line, across the road.
    """

    axis: int
    knots: NDArray[np.float64]
    pieces: NDArray[np.float64]
    half_width_px: float

    @classmethod
    def through(cls, points_px: NDArray[np.float64], axis: int, half_width_px: float) -> RoadCurve:
        """Fit a spline through points (n, 2), n >= 2, that are strictly monotone along ``axis``."""
        ordered = points_px[np.argsort(points_px[:, axis])]
        knots, values = np.ascontiguousarray(ordered[:, axis]), np.ascontiguousarray(ordered[:, 1 - axis])
        return cls(axis, knots, fit_cubic_spline(knots, values), half_width_px)

    def offset_and_direction(
        self, points_px: NDArray[np.float64], near_rad: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return for points (N, 2) the distance ``x - S(y)`` across the axis (N,) and the road's direction rθ (N,).

        The direction ``atan(1 / S'(y))`` (equation 3.9) is known up to half a turn; the value nearer to ``near_rad``
        (N,) is returned. Beyond its ends the spline is extrapolated.
        """
        values, slopes = evaluate_spline(self.knots, self.pieces, np.ascontiguousarray(points_px[:, self.axis]))
        one = np.ones_like(slopes)
        direction = np.arctan2(slopes, one) if self.axis == 0 else np.arctan2(one, slopes)
        half_turns = np.round((near_rad - direction) / np.pi)
        return points_px[:, 1 - self.axis] - values, direction + half_turns * np.pi


_KNOT_EVERY = 3
_LEAST_ADVANCE = 0.3
_RETRACE_FRAMES = 5
_KEPT_POINTS = 80
_END_POINTS = 7


class RoadModel:
    """Points of one road's centre line, tracked from frame to frame.

    * At first, and in every 5th frame while the car is estimated inside the picture, the lines are traced from the car,
      so that errors of the motion do not add up; the paper does not say how often.
    * In every other frame the points move with the ground, and each end inside the picture is extended by the second
      particle filter.
    * The spline is fitted through every 3rd point of the stretch around the car on which the road is monotone along one
      image axis, since only there it is a function of that axis.
    """

    def __init__(self, search: RoadSearch, car_px: float, rng: np.random.Generator) -> None:
        """Start without a road; the car is ``car_px`` long."""
        self._search = search
        self._car_px = car_px
        self._rng = rng
        self._points_px = np.empty((0, 2))
        self._half_width_px = 0.0
        self._frames_since_trace = _RETRACE_FRAMES

    def update(
        self,
        grey: NDArray[np.uint8],
        motion: Motion,
        car_px: NDArray[np.float64],
        heading_rad: float | None,
    ) -> RoadCurve | None:
        """Update with a picture (H, W) and return the road around the car; None while no road is known.

        ``motion`` is the ground's since the last picture; ``car_px`` (2,) and ``heading_rad`` are the car's position
        and heading *in the last picture*, the heading None while it is unknown.
        """
        finder = LineFinder(grey, self._car_px, self._search)
        self._points_px = motion.move(self._points_px)
        car_px, heading_rad = _carry(motion, car_px, heading_rad)
        self._frames_since_trace += 1
        traced = False
        if finder.inside(car_px) and self._frames_since_trace >= _RETRACE_FRAMES:
            traced = self._trace(finder, car_px, heading_rad)
        if not traced:
            self._grow(finder)
        return self._curve(car_px)

    def _trace(self, finder: LineFinder, car_px: NDArray[np.float64], heading_rad: float | None) -> bool:
        """Trace the lines from the car in both directions; False if there are none, or of another road's width."""
        all_around = np.arange(36) * np.pi / 36
        directions = all_around if heading_rad is None else heading_rad + np.linspace(-0.3, 0.3, 7)
        section = finder.cross_section(car_px, directions)
        if section is None:
            return False
        known = self._half_width_px
        if known > 0 and abs(section.half_width_px - known) > 0.25 * known:
            return False
        seeds = [
            RoadEnd(section.centre_px, section.direction_rad + turn, 0.0, finder, self._rng) for turn in (0.0, np.pi)
        ]
        ahead, behind = (end.grow(finder, section.half_width_px) for end in seeds)
        if len(ahead) + len(behind) < 3:
            return False
        self._points_px = np.array([*behind[::-1], section.centre_px, *ahead])
        self._half_width_px = section.half_width_px
        self._frames_since_trace = 0
        return True

    def _grow(self, finder: LineFinder) -> None:
        """Extend both ends inside the picture."""
        for _ in range(2):
            # Each pass extends the last end and reverses the line; two passes restore its order.
            if len(self._points_px) >= 3 and finder.inside(self._points_px[-1]):
                end = RoadEnd(*_last_piece(self._points_px[-_END_POINTS:]), finder, self._rng)
                self._points_px = np.array([*self._points_px, *end.grow(finder, self._half_width_px)])
                self._points_px = self._points_px[-_KEPT_POINTS:]
            self._points_px = self._points_px[::-1]

    def _curve(self, car_px: NDArray[np.float64]) -> RoadCurve | None:
        points = self._points_px
        if len(points) < 2:
            return None
        nearest = int(np.argmin(np.hypot(*(points - car_px).T)))
        steps = np.diff(points, axis=0)
        local = steps[min(nearest, len(steps) - 1)]
        axis = int(np.argmax(np.abs(local)))
        advance = steps[:, axis] * np.sign(local[axis])
        good = advance > _LEAST_ADVANCE * self._search.step * self._car_px
        first = last = nearest
        while first > 0 and good[first - 1]:
            first -= 1
        while last < len(points) - 1 and good[last]:
            last += 1
        if last - first < 1:
            return None
        chosen = np.unique(np.append(np.arange(first, last, _KNOT_EVERY), last))
        if len(chosen) > 2 and chosen[-1] - chosen[-2] < _KNOT_EVERY:
            chosen = np.delete(chosen, -2)
        return RoadCurve.through(points[chosen], axis, self._half_width_px)


def _carry(
    motion: Motion, car_px: NDArray[np.float64], heading_rad: float | None
) -> tuple[NDArray[np.float64], float | None]:
    """Return a position and a heading moved with the ground."""
    moved = motion.move(car_px)
    if heading_rad is None:
        return moved, None
    ahead = motion.move(car_px + np.array([np.cos(heading_rad), np.sin(heading_rad)])) - moved
    return moved, float(np.arctan2(ahead[1], ahead[0]))


def _last_piece(points_px: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, float]:
    """Return position (2,), direction and curvature of a line's end, by a parabola through points (n, 2), n >= 3."""
    chord = points_px[-1] - points_px[0]
    along = chord / max(float(np.hypot(*chord)), 1e-9)
    across = np.array([-along[1], along[0]])
    offsets = points_px - points_px[-1]
    quadratic, slope, level = np.polyfit(offsets @ along, offsets @ across, 2)
    direction_rad = float(np.arctan2(along[1], along[0]) + np.arctan(slope))
    return points_px[-1] + level * across, direction_rad, float(2 * quadratic / (1 + slope**2) ** 1.5)
