"""Tools for street patterns: control points, guide curves with stations, superellipses, a smooth warp."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.street_curves import Road


class Sketch:
    """Control points, and the roads through them."""

    def __init__(self) -> None:
        self._points: list[NDArray[np.float64]] = []
        self.roads: list[Road] = []

    def add(self, point_m: NDArray[np.float64]) -> int:
        """Add a control point (2,) and return its index."""
        self._points.append(np.asarray(point_m, dtype=float))
        return len(self._points) - 1

    def point(self, index: int) -> NDArray[np.float64]:
        """Return the control point (2,) of an index."""
        return self._points[index]

    @property
    def points_m(self) -> NDArray[np.float64]:
        """All control points (P, 2)."""
        return np.array(self._points)


class Rail:
    """A guide curve ``at(t)`` that collects stations in any order and becomes a road through them."""

    def __init__(
        self,
        sketch: Sketch,
        at: Callable[[float], NDArray[np.float64]],
        width_m: float,
        closed_period: float | None = None,
    ) -> None:
        self._sketch = sketch
        self._at = at
        self._width_m = width_m
        self._period = closed_period
        self._stations: list[tuple[float, int]] = []

    def put(self, t: float, point: int) -> None:
        """Make an existing control point a station at parameter ``t``."""
        self._stations.append((t if self._period is None else t % self._period, point))

    def station(self, t: float, snap_m: float = 0.0) -> int:
        """Return the station at ``t``: an existing one within ``snap_m``, or a new one."""
        here = self._at(t)
        for _, point in self._stations:
            if np.linalg.norm(self._sketch.point(point) - here) < snap_m:
                return point
        point = self._sketch.add(here)
        self.put(t, point)
        return point

    def draw(self, fill_m: float) -> None:
        """Add the road to the sketch, with extra stations in gaps longer than ``fill_m``."""
        stations = sorted(self._stations)
        if self._period is not None:
            stations.append((stations[0][0] + self._period, stations[0][1]))
        points = [stations[0][1]]
        for (t0, p0), (t1, p1) in pairwise(stations):
            gap_m = np.linalg.norm(self._sketch.point(p1) - self._sketch.point(p0))
            for t in np.linspace(t0, t1, int(np.ceil(gap_m / fill_m)) + 1)[1:-1]:
                points.append(self._sketch.add(self._at(float(t))))
            points.append(p1)
        closed = self._period is not None
        self._sketch.roads.append(Road(tuple(points[:-1] if closed else points), self._width_m, closed))


def superellipse(half_m: float, exponent: float) -> Callable[[float], NDArray[np.float64]]:
    """Return angle → point (2,) of ``|x|^n + |y|^n = half^n``: a circle for n = 2, a rounded square for more."""

    def at(angle_rad: float) -> NDArray[np.float64]:
        direction = np.array([np.cos(angle_rad), np.sin(angle_rad)])
        radius_m = half_m / float(np.sum(np.abs(direction) ** exponent) ** (1.0 / exponent))
        return radius_m * direction

    return at


def height_on_superellipse(x_m: float, half_m: float, exponent: float) -> float:
    """Return y >= 0 of the superellipse's point above ``x_m``."""
    return float((half_m**exponent - abs(x_m) ** exponent) ** (1.0 / exponent))


def smooth_warp(
    rng: np.random.Generator, extent_m: float, amplitude_m: float
) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Return a smooth random displacement of the plane: a sum of waves 0.45 to 1 extent long."""
    count = 5
    wavelength_m = extent_m * rng.uniform(0.45, 1.0, count)
    heading = rng.uniform(0, 2 * np.pi, count)
    wave = np.stack([np.cos(heading), np.sin(heading)]) * 2 * np.pi / wavelength_m
    phase = rng.uniform(0, 2 * np.pi, count)
    push = rng.normal(0, amplitude_m / np.sqrt(count), (count, 2))

    def warp(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        moved: NDArray[np.float64] = points_m + np.sin(points_m @ wave + phase) @ push
        return moved

    return warp
