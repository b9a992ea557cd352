"""The second particle filter of paper A: the line of newly seen road at the end of the known one (section 3.1).

All positions are in pixels from the image centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.particle_filter import ParticleFilter
from trackers.road_shape.road_lines import LineFinder
from trackers.road_shape.spline import evaluate_spline, fit_cubic_spline

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
    """What the filter sees of newly seen road.

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
    distance, and a row without any says nothing.
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
