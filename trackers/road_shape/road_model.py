"""The road's shape: a cubic spline through points of its centre line, which move with the ground and are extended where
new road comes into view (paper A, section 3.1; A.2 steps 1-3).

All positions are in pixels from the image centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.road_shape.background_motion import Motion
from trackers.road_shape.road_end import RoadEnd
from trackers.road_shape.road_lines import LineFinder, RoadSearch
from trackers.road_shape.spline import evaluate_spline, fit_cubic_spline


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


_LEAST_ADVANCE = 0.3
_KEPT_KNOTS = 80
_FIRST_STEP = 0.5


class RoadModel:
    """Knots of one road's centre line, tracked from frame to frame.

    * At first the lines beside the car are found, and traced both ways by the second particle filter: all road in view
      is newly seen, in steps of half a car's length. It is not traced again while the road is known: as in the paper,
      errors of the motion add up.
    * In every other frame the knots move with the ground, and each end inside the picture advances by the part of that
      motion along the road, at most to the border (``RoadEnd``).
    * The spline is fitted through the knots around the car between which the road is monotone along one image axis,
      since only there it is a function of that axis.

    Readings: the paper has one end, ahead; the road behind the car is known the same way. Lines are found again only
    after all knots are gone or if none were found.
    """

    def __init__(self, search: RoadSearch, car_px: float, rng: np.random.Generator) -> None:
        """Start without a road; the car is ``car_px`` long."""
        self._search = search
        self._car_px = car_px
        self._rng = rng
        self._knots_px = np.empty((0, 2))
        self._half_width_px = 0.0
        self._ends: list[RoadEnd] = []

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
        moved_px, heading_rad = _carry(motion, car_px, heading_rad)
        if len(self._knots_px):
            self._move(finder, motion)
        elif finder.inside(moved_px):
            self._trace(finder, moved_px, heading_rad)
        return self._curve(moved_px)

    def _trace(self, finder: LineFinder, car_px: NDArray[np.float64], heading_rad: float | None) -> None:
        """Find the lines beside the car and trace them both ways; without lines, or alone, there is no road."""
        all_around = np.arange(180) * np.pi / 180
        directions = all_around if heading_rad is None else heading_rad + np.linspace(-0.3, 0.3, 35)
        section = finder.cross_section(car_px, directions)
        if section is None:
            return
        self._half_width_px = section.half_width_px
        self._knots_px = section.centre_px[None]
        self._ends = [RoadEnd(section.direction_rad + turn, self._car_px, self._rng) for turn in (np.pi, 0.0)]
        for last in (False, True):
            end = self._ends[last]
            while not end.lost and (room_px := self._room_px(finder, last)) > 0:
                self._advance(finder, last, min(room_px, _FIRST_STEP * self._car_px))
        if len(self._knots_px) < 3:
            self._knots_px = np.empty((0, 2))

    def _move(self, finder: LineFinder, motion: Motion) -> None:
        """Move the knots with the ground, and advance both ends by what the motion shows of the road."""
        tips_px = [end.tip_px(self._outermost(last)) for last, end in enumerate(self._ends)]
        self._knots_px = motion.move(self._knots_px)
        for last, end in enumerate(self._ends):
            end.turn(self._outward(last))
            ahead = np.array([np.cos(end.tip_rad), np.sin(end.tip_rad)])
            shown_px = float((tips_px[last] - motion.move(tips_px[last])) @ ahead)
            if shown_px > 0 and not end.lost and (room_px := self._room_px(finder, last)) > 0:
                self._advance(finder, bool(last), min(shown_px, room_px))

    def _room_px(self, finder: LineFinder, last: int) -> float:
        end = self._ends[last]
        return finder.room_px(end.tip_px(self._outermost(last)), end.tip_rad, self._half_width_px)

    def _advance(self, finder: LineFinder, last: bool, length_px: float) -> None:
        end = self._ends[last]
        knot = end.advance(finder, self._outermost(last), length_px, self._half_width_px)
        if knot is None:
            return
        outward = np.concatenate([self._outward(last), knot[None]])[-_KEPT_KNOTS:]
        end.turn(outward)
        self._knots_px = outward if last else outward[::-1]

    def _outward(self, last: int) -> NDArray[np.float64]:
        """Return the knots (n, 2) in the order towards the first or the last of them."""
        return self._knots_px if last else self._knots_px[::-1]

    def _outermost(self, last: int) -> NDArray[np.float64]:
        return self._outward(last)[-1]

    def _curve(self, car_px: NDArray[np.float64]) -> RoadCurve | None:
        knots = self._knots_px
        if len(knots) < 2:
            return None
        nearest = int(np.argmin(np.hypot(*(knots - car_px).T)))
        steps = np.diff(knots, axis=0)
        local = steps[min(nearest, len(steps) - 1)]
        axis = int(np.argmax(np.abs(local)))
        good = steps[:, axis] * np.sign(local[axis]) > _LEAST_ADVANCE * self._car_px
        first = last = nearest
        while first > 0 and good[first - 1]:
            first -= 1
        while last < len(knots) - 1 and good[last]:
            last += 1
        return None if last == first else RoadCurve.through(knots[first : last + 1], axis, self._half_width_px)


def _carry(
    motion: Motion, car_px: NDArray[np.float64], heading_rad: float | None
) -> tuple[NDArray[np.float64], float | None]:
    """Return a position and a heading moved with the ground."""
    moved = motion.move(car_px)
    if heading_rad is None:
        return moved, None
    ahead = motion.move(car_px + np.array([np.cos(heading_rad), np.sin(heading_rad)])) - moved
    return moved, float(np.arctan2(ahead[1], ahead[0]))
