"""Detection and tracing of a road's white lines in a picture (paper A, section 3.1).

All positions are in pixels from the image centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.paper_a.edges import line_positions, line_profile
from trackers.particle_filter import ParticleFilter


@dataclass(frozen=True)
class RoadSearch:
    """Settings of the search for lines; lengths are in lengths of the car, the only object of known size.

    Attributes:
        reach: largest distance of a line from the car. nearest: smallest distance; nearer edges are the car's own.
        step: distance between traced points. nearby: largest distance of a line from its expected position.
        least_contrast: grey values by which a line is brighter than both its sides.
        blind_steps: number of points in a row without an edge nearby at which tracing ends.
        end_particles: N of the second filter. curvature_noise: τR, radians a step.
        misfit: unit of distance in d of equation 3.6.
    """

    reach: float = 1.7
    nearest: float = 0.25
    step: float = 0.5
    nearby: float = 0.22
    least_contrast: float = 12.0
    blind_steps: int = 6
    end_particles: int = 60
    curvature_noise: float = 0.04
    misfit: float = 0.06


@dataclass(frozen=True)
class CrossSection:
    """Cross section of the road: centre (2,) between its edge lines, direction in radians, half width in pixels."""

    centre_px: NDArray[np.float64]
    direction_rad: float
    half_width_px: float
    contrast: float


class LineFinder:
    """Searches one picture for a road's white lines."""

    def __init__(self, grey: NDArray[np.uint8], car_px: float, search: RoadSearch) -> None:
        """Search in ``grey`` (H, W) with a car ``car_px`` long."""
        self._grey = grey
        self._centre_px = 0.5 * np.array([grey.shape[1], grey.shape[0]])
        self.car_px = car_px
        self.search = search
        self._thickness_px = max(2, round(0.07 * car_px))

    def inside(self, point_px: NDArray[np.float64]) -> bool:
        """Return whether a point (2,) lies in the picture."""
        return bool((np.abs(point_px) < self._centre_px).all())

    def profile(self, centre_px: NDArray[np.float64], direction_rad: float, along: float) -> NDArray[np.float64]:
        """Return the line profile across a direction, averaged over ``along`` car lengths either way."""
        return line_profile(
            self._grey,
            centre_px + self._centre_px,
            direction_rad,
            round(self.search.reach * self.car_px),
            self._thickness_px,
            round(along * self.car_px),
        )

    def cross_section(self, car_px: NDArray[np.float64], directions_rad: NDArray[np.float64]) -> CrossSection | None:
        """Return the strongest pair of lines, one on each side of a car (2,), over the given directions.

        The search is at the car and one car length before and behind it. None if there is no pair.
        """
        best: CrossSection | None = None
        nearest = self.search.nearest * self.car_px
        for direction in directions_rad:
            ahead = self.car_px * np.array([np.cos(direction), np.sin(direction)])
            right = np.array([-np.sin(direction), np.cos(direction)])
            for shift in (-1.0, 0.0, 1.0):
                place = car_px + shift * ahead
                profile = self.profile(place, direction, 0.8)
                middle = profile.size // 2
                skip = round(nearest)
                to_left = int(np.argmax(profile[: middle - skip][::-1])) + skip + 1
                to_right = int(np.argmax(profile[middle + skip + 1 :])) + skip + 1
                contrast = float(min(profile[middle - to_left], profile[middle + to_right]))
                if contrast > self.search.least_contrast and (best is None or contrast > best.contrast):
                    centre = place + 0.5 * (to_right - to_left) * right
                    best = CrossSection(centre, float(direction), 0.5 * (to_left + to_right), contrast)
        return best


@dataclass(frozen=True)
class _Ahead:
    """Offsets of edges across the road near its two lines, at distances (J,) ahead of the road's end."""

    distances_px: tuple[float, ...]
    edges_px: tuple[tuple[NDArray[np.float64], float], ...]


class _EndModel:
    """State (rx, R) at a road's end: position across the road and curvature; ry is common to all particles.

    In the frame of the last point, its axis along the road: ``ry' = ry + step``, ``R' = R + N(0, τR²)``,
    ``rx' = S(ry')`` with S the last piece extrapolated at curvature R' (equations 3.3-3.5);
    ``d = Σ (S̃ - G)²`` over the edges G nearest to the predicted lines, weight ``exp(-d)`` (3.6, 3.7).
    Readings: the paper prints d squared twice, here it is squared once; a line without an edge nearby adds the square
    of the largest search distance.
    """

    def __init__(self, curvature_per_px: float, step_px: float, search: RoadSearch, car_px: float) -> None:
        self._start_curvature = curvature_per_px
        self._step_px = step_px
        self._curvature_noise = search.curvature_noise / step_px
        self._misfit_px = search.misfit * car_px
        self._cap_px = search.nearby * car_px

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        states = np.zeros((count, 2))
        states[:, 1] = rng.normal(self._start_curvature, self._curvature_noise, count)
        return states

    def predict(self, states: NDArray[np.float64], observed: _Ahead, rng: np.random.Generator) -> NDArray[np.float64]:
        curvature = states[:, 1] + rng.normal(0.0, self._curvature_noise, len(states))
        return np.column_stack([states[:, 0] + 0.5 * curvature * self._step_px**2, curvature])

    def log_weights(self, states: NDArray[np.float64], observed: _Ahead) -> NDArray[np.float64]:
        d = np.zeros(len(states))
        for distance_px, (edges_px, line_px) in zip(observed.distances_px, observed.edges_px, strict=True):
            across = states[:, 0] - 0.5 * states[:, 1] * (self._step_px**2 - distance_px**2)
            misfit = np.full(len(states), self._cap_px)
            if edges_px.size:
                nearest = np.abs((across + line_px)[:, None] - edges_px).min(axis=1)
                misfit = np.minimum(nearest, self._cap_px)
            d += (misfit / self._misfit_px) ** 2
        return -d


class RoadEnd:
    """One growing end of the traced road."""

    def __init__(
        self,
        origin_px: NDArray[np.float64],
        direction_rad: float,
        curvature_per_px: float,
        finder: LineFinder,
        rng: np.random.Generator,
    ) -> None:
        self._step_px = finder.search.step * finder.car_px
        model = _EndModel(curvature_per_px, self._step_px, finder.search, finder.car_px)
        self._filter = ParticleFilter[_Ahead](model, finder.search.end_particles, rng)
        self._origin_px, self._direction_rad = origin_px, direction_rad

    def grow(self, finder: LineFinder, half_width_px: float) -> list[NDArray[np.float64]]:
        """Return the points ahead, up to the picture's border or the last edge nearby (see ``blind_steps``)."""
        points: list[NDArray[np.float64]] = []
        blind = 0
        while len(points) < 80:
            ahead = self._look(finder, half_width_px)
            blind = 0 if any(edges.size for edges, _ in ahead.edges_px) else blind + 1
            posterior = self._filter.step(ahead)
            across, curvature = posterior.weights @ posterior.states
            point = self._place(self._step_px, across)
            if blind > finder.search.blind_steps or not finder.inside(point):
                break
            # The frame moves with the end, and the states are relative to it.
            chord = float(np.arctan2(*(point - self._origin_px)[::-1]))
            self._origin_px, self._direction_rad = point, chord + 0.5 * curvature * self._step_px
            self._filter.states = self._filter.states - np.array([across, 0.0])
            points.append(point)
        return points[: len(points) - blind]

    def _place(self, along_px: float, across_px: float) -> NDArray[np.float64]:
        c, s = np.cos(self._direction_rad), np.sin(self._direction_rad)
        return self._origin_px + along_px * np.array([c, s]) + across_px * np.array([-s, c])

    def _look(self, finder: LineFinder, half_width_px: float) -> _Ahead:
        curvature = float(self._filter.states[:, 1].mean())
        reach = finder.search.nearby * finder.car_px
        distances, edges = [], []
        for distance in (0.5 * self._step_px, self._step_px):
            bend = 0.5 * curvature * distance**2
            direction = self._direction_rad + curvature * distance
            profile = finder.profile(self._place(distance, bend), direction, 0.08)
            for line in (-half_width_px, half_width_px):
                found = line_positions(profile, line - reach, line + reach, finder.search.least_contrast)
                distances.append(distance)
                edges.append((found + bend, line))
        return _Ahead(tuple(distances), tuple(edges))
