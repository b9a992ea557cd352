"""The road's shape: a cubic spline through points of its centre line (paper A, section 3.1; A.2 steps 1 to 3).

The points move with the ground. Where new road comes into view, a second particle filter finds its line. All positions
are in pixels from the image centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.particle_filter import ParticleFilter
from trackers.road_shape.background_motion import Motion
from trackers.road_shape.road_lines import LineFinder, RoadSearch


def fit_cubic_spline(knots: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the pieces ``S_i(y) = a_i (y - y_i)^3 + b_i (y - y_i)^2 + c_i (y - y_i) + d_i`` through n >= 2 points.

    With M_i = S''(y_i), h_i = y_{i+1} - y_i and slopes s_i = (d_{i+1} - d_i) / h_i:
    ``h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (s_i - s_{i-1})`` inside and, at the ends,
    ``M_0 = M_1, M_{n-1} = M_{n-2}``;
    ``a_i = (M_{i+1} - M_i) / (6 h_i), b_i = M_i / 2, c_i = s_i - h_i (2 M_i + M_{i+1}) / 6``.

    The end conditions are a reading: the first and last piece are parabolas, so the extrapolation keeps the curvature
    of the ends. (A natural spline's curvature changes its sign there.)

    Args:
        knots: (n,) y_i, strictly increasing.
        values: (n,) d_i.

    Returns:
        (n - 1, 4) rows a, b, c, d.
    """
    n = knots.size
    h = knots[1:] - knots[:-1]
    s = (values[1:] - values[:-1]) / h
    M: NDArray[np.floating] = np.zeros(n)
    if n >= 3:
        system = np.zeros((n, n))
        right = np.zeros(n)
        system[0, 0], system[0, 1] = 1.0, -1.0
        system[n - 1, n - 1], system[n - 1, n - 2] = 1.0, -1.0
        for i in range(1, n - 1):
            system[i, i - 1], system[i, i], system[i, i + 1] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
            right[i] = 6.0 * (s[i] - s[i - 1])
        M = np.linalg.solve(system, right)
    pieces = np.empty((n - 1, 4))
    pieces[:, 0] = (M[1:] - M[:-1]) / (6.0 * h)
    pieces[:, 1] = 0.5 * M[:-1]
    pieces[:, 2] = s - h * (2.0 * M[:-1] + M[1:]) / 6.0
    pieces[:, 3] = values[:-1]
    return pieces


@njit(cache=True)
def evaluate_spline(
    knots: NDArray[np.float64], pieces: NDArray[np.float64], at: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return S(y) and S'(y), both (N,), at positions (N,); beyond the ends the first or last piece is extrapolated.

    Args:
        knots: (n,); pieces: (n - 1, 4), from ``fit_cubic_spline``.
    """
    values = np.empty(at.size)
    slopes = np.empty(at.size)
    for k in range(at.size):
        i = min(max(np.searchsorted(knots, at[k], side="right") - 1, 0), len(pieces) - 1)
        a, b, c, d = pieces[i]
        y = at[k] - knots[i]
        values[k] = ((a * y + b) * y + c) * y + d
        slopes[k] = (3.0 * a * y + 2.0 * b) * y + c
    return values, slopes


_LAST_KNOTS = 4


@dataclass(frozen=True)
class RoadEndParameters:
    """Settings of the second filter; the paper gives no values, lengths are in lengths of the car.

    Attributes:
        particles: N.
        curvature_noise: τR, radians per half a length of the car, for that much newly seen road.
        knot_spacing: distance between knots of the spline: the paper keeps "a few points".
        row_spacing: distance between rows in which edges are looked for.
        blind: length of road without an edge at which the end is lost.
    """

    particles: int = 1000
    curvature_noise: float = 0.04
    knot_spacing: float = 1.0
    row_spacing: float = 0.25
    blind: float = 6.0


@dataclass(frozen=True)
class NewRoad:
    """Input of the filter: a piece of newly seen road.

    Attributes:
        length_px: hx, by which the end has advanced.
        ahead_px: (J,) distances ry of the rows from the last knot, each line's rows in turn.
        edges_px: J arrays: where the road's centre would be, across the road, by each edge G near a line in that row.
        cap_px: largest distance of a nearby edge.
    """

    length_px: float
    ahead_px: tuple[float, ...]
    edges_px: tuple[NDArray[np.float64], ...]
    cap_px: float


class NewRoadModel:
    """State R, the curvature of the new piece in 1/px; (rx, ry) follow from it.

    In the frame of the last knot, y along the road there and x across it, the last piece of the spline goes on as
    ``S̃(y) = R y² / 2``, so ``rx = S̃(ry)`` (3.3), ``ry' = ry + hx`` (3.4), ``R' = R + N(0, τR²)`` (3.5);
    ``d = Σ (S̃ - G)²`` in pixels over the nearest edges G to the road's two lines, weight ``exp(-d)`` (3.6, 3.7).

    Readings: y is the road's own direction, to which the paper's image axis is near; hx is the helicopter's motion
    along it; the noise is that of half a car's length of new road, since frames show unequal lengths of it; the paper
    prints d squared twice, here it is squared once. "Nearby" edges: farther ones count as edges at the largest nearby
    distance, and a row without any has no weight.
    """

    def __init__(self, curvature_per_px: float, car_px: float, noise: float) -> None:
        self._start = curvature_per_px
        self._half_car_px = 0.5 * car_px
        self._noise_per_px = noise / self._half_car_px

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.normal(self._start, self._noise_per_px, (count, 1))

    def predict(self, states: NDArray[np.float64], observed: NewRoad, rng: np.random.Generator) -> NDArray[np.float64]:
        share = np.sqrt(observed.length_px / self._half_car_px)
        return states + rng.normal(0.0, share * self._noise_per_px, states.shape)

    def log_weights(self, states: NDArray[np.float64], observed: NewRoad) -> NDArray[np.float64]:
        d = np.zeros(len(states))
        for ahead_px, edges_px in zip(observed.ahead_px, observed.edges_px, strict=True):
            if edges_px.size:
                nearest_px = np.abs(0.5 * states * ahead_px**2 - edges_px).min(axis=1)
                d += np.minimum(nearest_px, observed.cap_px) ** 2
        return -d


class RoadEnd:
    """One end of the known road, which advances as the helicopter's motion shows more of it.

    Attributes:
        direction_rad: of the road at its last knot, away from the others.
    """

    def __init__(self, direction_rad: float, car_px: float, rng: np.random.Generator) -> None:
        """Start at the first knot, where the road leads on along ``direction_rad``."""
        self._parameters = RoadEndParameters()
        self._car_px = car_px
        model = NewRoadModel(0.0, car_px, self._parameters.curvature_noise)
        self._filter = ParticleFilter[NewRoad](model, self._parameters.particles, rng)
        self._curvature_per_px = 0.0
        self._ahead_px = 0.0
        self.direction_rad = direction_rad

    @property
    def lost(self) -> bool:
        """Whether no edge has been seen for so long that the end advances no more."""
        return self._ahead_px > self._parameters.blind * self._car_px

    @property
    def tip_rad(self) -> float:
        """Direction of the road at the end of the new piece."""
        return self.direction_rad + self._curvature_per_px * self._ahead_px

    def turn(self, knots_px: NDArray[np.float64]) -> None:
        """Take the direction of the last piece of the spline through the knots (n, 2), the last one outermost."""
        if len(knots_px) >= 3:
            self.direction_rad = last_direction(knots_px[-_LAST_KNOTS:])

    def tip_px(self, knot_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the new piece ends, (rx, ry) as a point (2,), by its last knot (2,)."""
        return self._place(knot_px, self._ahead_px)

    def advance(
        self, finder: LineFinder, knot_px: NDArray[np.float64], length_px: float, half_width_px: float
    ) -> NDArray[np.float64] | None:
        """Advance by ``length_px`` of newly seen road, from the last knot (2,); return a new knot (2,) or None.

        A knot is set where an edge is seen, once the last one is far enough behind.
        """
        seen = self._look(finder, knot_px, length_px, half_width_px)
        posterior = self._filter.step(seen)
        self._curvature_per_px = float(posterior.weights @ posterior.states[:, 0])
        self._ahead_px += length_px
        found = any(edges.size for edges in seen.edges_px)
        if not found or self._ahead_px < self._parameters.knot_spacing * self._car_px:
            return None
        knot = self.tip_px(knot_px)
        self.direction_rad += self._curvature_per_px * self._ahead_px
        self._ahead_px = 0.0
        return knot

    def _look(
        self, finder: LineFinder, knot_px: NDArray[np.float64], length_px: float, half_width_px: float
    ) -> NewRoad:
        rows = max(1, int(np.ceil(length_px / (self._parameters.row_spacing * self._car_px))))
        ahead: list[float] = []
        edges: list[NDArray[np.float64]] = []
        for row in range(1, rows + 1):
            ahead_px = self._ahead_px + length_px * row / rows
            place_px = self._place(knot_px, ahead_px)
            direction_rad = self.direction_rad + self._curvature_per_px * ahead_px
            for line_px in (-half_width_px, half_width_px):
                offsets_px = finder.edges(place_px, direction_rad, line_px)
                ahead.append(ahead_px)
                edges.append(offsets_px - line_px + self._bend_px(ahead_px))
        return NewRoad(length_px, tuple(ahead), tuple(edges), finder.search.nearby * self._car_px)

    def _bend_px(self, ahead_px: float) -> float:
        return 0.5 * self._curvature_per_px * ahead_px**2

    def _place(self, knot_px: NDArray[np.float64], ahead_px: float) -> NDArray[np.float64]:
        c, s = np.cos(self.direction_rad), np.sin(self.direction_rad)
        return knot_px + ahead_px * np.array([c, s]) + self._bend_px(ahead_px) * np.array([-s, c])


def last_direction(knots_px: NDArray[np.float64]) -> float:
    """Return the direction in which a spline through knots (n, 2), n >= 2, leaves the last one, away from the others.

    Their chord is the axis along which the spline is a function.
    """
    chord = float(np.arctan2(*(knots_px[-1] - knots_px[0])[::-1]))
    c, s = np.cos(chord), np.sin(chord)
    offsets = knots_px - knots_px[0]
    along, across = offsets @ [c, s], offsets @ [-s, c]
    if (np.diff(along) <= 0).any():
        return float(np.arctan2(*(knots_px[-1] - knots_px[-2])[::-1]))
    _, slope = evaluate_spline(along, fit_cubic_spline(along, across), along[-1:])
    return chord + float(np.arctan(slope[0]))


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
        self, grey: NDArray[np.uint8], motion: Motion, car_px: NDArray[np.float64], heading_rad: float | None
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
