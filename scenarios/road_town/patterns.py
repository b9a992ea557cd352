"""Street patterns of towns. A new pattern is one decorated function.

    @street_pattern("comb")
    def comb(rng, extent_m):
        sketch = Sketch()
        ...                                   # add points and roads
        return graph_of_roads(sketch.points_m, sketch.roads)

A pattern draws a sketch (control points and the roads through them); ``street_curves`` turns it into curves. The
patterns here redraw with decreasing randomness until the network is valid, so every seed gives a usable town.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import RoadGraph
from scenarios.road_town.street_curves import MIN_RADIUS_M, Road, fault_of, graph_of_roads


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


DEFAULT_EXTENT_M = 420.0
SMALLEST_EXTENT_M = 300.0
EDGE_MARGIN_M = 38.0
"""Margin without roads at every edge, so that houses and gardens stand outside the last street too."""
SNAP_M = 30.0
"""A street that would join another one this close to a crossing uses that crossing."""

Pattern = Callable[[np.random.Generator, float], RoadGraph]

STREET_PATTERNS: dict[str, Pattern] = {}


def street_pattern(name: str) -> Callable[[Pattern], Pattern]:
    """Register a pattern ``f(rng, extent_m) -> RoadGraph`` under ``name``."""

    def register(pattern: Pattern) -> Pattern:
        if name in STREET_PATTERNS:
            raise ValueError(f"name: expected a new street pattern, got {name!r}, which is registered already")
        STREET_PATTERNS[name] = pattern
        return pattern

    return register


def make_streets(name: str, rng: np.random.Generator, extent_m: float = DEFAULT_EXTENT_M) -> RoadGraph:
    """Draw the streets of a town.

    Args:
        name: a registered pattern.
        extent_m: side of the square ground, >= 300 m.

    Raises:
        ValueError: unknown pattern, or an extent too small for a town.
    """
    if name not in STREET_PATTERNS:
        raise ValueError(f"pattern: expected one of {sorted(STREET_PATTERNS)}, got {name!r}")
    if not extent_m >= SMALLEST_EXTENT_M:
        raise ValueError(f"extent_m: expected at least {SMALLEST_EXTENT_M:g}, got {extent_m}")
    return STREET_PATTERNS[name](rng, extent_m)


@street_pattern("grid")
def grid(rng: np.random.Generator, extent_m: float) -> RoadGraph:
    """A planned town: two sets of gently curved streets inside a rounded ring road."""
    half_m, exponent = extent_m / 2 - EDGE_MARGIN_M - 8.0, 4.5

    def draw(strength: float) -> Sketch:
        sketch = Sketch()
        ring = Rail(sketch, superellipse(half_m, exponent), 9.0, closed_period=2 * np.pi)
        lines = [_lines(rng, half_m, strength) for _ in range(2)]
        crossing_m = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        crossing_m = crossing_m + rng.normal(0, 6.0 * strength, crossing_m.shape)
        inner = np.array([[sketch.add(point) for point in column] for column in crossing_m])
        for axis, streets in ((1, inner), (0, inner.T)):
            for points in streets:
                street = Rail(sketch, _no_fill, _width(rng))
                for place, point in enumerate(points):
                    street.put(place, int(point))
                for place, side in ((-1, -1.0), (len(points), 1.0)):
                    end_m = sketch.point(int(points[0 if place < 0 else -1])).copy()
                    end_m[axis] = side * height_on_superellipse(end_m[1 - axis], half_m, exponent)
                    street.put(place, ring.station(float(np.arctan2(end_m[1], end_m[0]))))
                street.draw(fill_m=np.inf)
        ring.draw(fill_m=35.0)
        return sketch

    return _first_sound(rng, draw, extent_m, warp_m=7.0)


@street_pattern("organic")
def organic(rng: np.random.Generator, extent_m: float) -> RoadGraph:
    """A grown town: staggered irregular blocks and curved streets; T and X crossings."""
    half_m, exponent = extent_m / 2 - EDGE_MARGIN_M - 22.0, 3.0

    def draw(strength: float) -> Sketch:
        sketch = Sketch()
        ring = Rail(sketch, superellipse(half_m, exponent), 8.6, closed_period=2 * np.pi)
        heights_m = _lines(rng, half_m, strength)
        rows = [_row(sketch, ring, height, half_m, exponent, _width(rng)) for height in heights_m]
        lanes: dict[int, list[int]] = {}
        for gap in range(len(rows) + 1):
            middle_m = np.mean([*heights_m[max(gap - 1, 0) : gap + 1]])
            reach_m = height_on_superellipse(float(middle_m), half_m, exponent) - 42.0
            for x_m in _spaced(rng, -reach_m, reach_m, 62.0, 105.0):
                low = _join(rows, ring, gap - 1, x_m, half_m, exponent)
                high = _join(rows, ring, gap, x_m + rng.normal(0, 9.0 * strength), half_m, exponent)
                bend_m = 0.5 * (sketch.point(low) + sketch.point(high)) + rng.normal(0, 6.0 * strength, 2)
                lanes[high] = [*lanes.pop(low, [low]), sketch.add(bend_m), high]
        for lane in lanes.values():
            street = Rail(sketch, _no_fill, _width(rng))
            for place, point in enumerate(lane):
                street.put(place, point)
            street.draw(fill_m=np.inf)
        for row in rows:
            row.draw(fill_m=45.0)
        ring.draw(fill_m=35.0)
        return sketch

    return _first_sound(rng, draw, extent_m, warp_m=24.0)


@street_pattern("ring")
def ring(rng: np.random.Generator, extent_m: float) -> RoadGraph:
    """An old town: a ring round the market place, an outer ring, another between, and radials."""
    half_m = extent_m / 2 - EDGE_MARGIN_M - 8.0

    def draw(strength: float) -> Sketch:
        sketch = Sketch()
        radii_m = half_m * np.array([0.25, rng.uniform(0.58, 0.64), 1.0])
        exponents = (2.0, 2.2, 3.0)
        rings = [
            Rail(sketch, superellipse(radius, exponent), width, closed_period=2 * np.pi)
            for radius, exponent, width in zip(radii_m, exponents, (7.6, 7.4, 9.0), strict=True)
        ]
        count = int(rng.integers(5, 7))
        angles = rng.uniform(0, 2 * np.pi) + (np.arange(count) + rng.uniform(-0.2, 0.2, count)) * 2 * np.pi / count
        for angle in angles:
            twist = rng.normal(0, 0.10 * strength, 3).cumsum()
            radial = Rail(sketch, _no_fill, _width(rng))
            for place, rail in enumerate(rings):
                radial.put(place, rail.station(angle + twist[place]))
            radial.draw(fill_m=np.inf)
        for angle in 0.5 * (angles + np.append(angles[1:], angles[0] + 2 * np.pi)):
            if rng.random() < 0.45:
                lane = Rail(sketch, _no_fill, _width(rng))
                for place, rail in enumerate(rings[1:]):
                    lane.put(place, rail.station(angle + rng.normal(0, 0.06 * strength)))
                lane.draw(fill_m=np.inf)
        for rail in rings:
            rail.draw(fill_m=28.0)
        return sketch

    return _first_sound(rng, draw, extent_m, warp_m=9.0)


@street_pattern("winding")
def winding(rng: np.random.Generator, extent_m: float) -> RoadGraph:
    """One long winding road, closed so that no car gets stuck, bends of 25 to 60 m radius, a few side streets."""
    half_m = extent_m / 2 - EDGE_MARGIN_M
    lobes = 5

    def draw(strength: float) -> Sketch:
        sketch = Sketch()
        depth = 0.165 * (0.6 + 0.4 * strength)
        phase = rng.uniform(0, 2 * np.pi)
        swing = rng.normal(0, 0.03 * strength, 2)
        mean_m = 0.80 * half_m

        def at(angle: float) -> NDArray[np.float64]:
            wave = depth * np.cos(lobes * (angle - phase)) + swing @ (np.cos(2 * angle), np.sin(3 * angle))
            radius_m = mean_m * (1 + wave) * float(rounded(angle))
            return radius_m * np.array([np.cos(angle), np.sin(angle)])

        def rounded(angle: float) -> float:
            return float(np.linalg.norm(superellipse(1.0, 2.4)(angle)))

        road = Rail(sketch, at, 8.4, closed_period=2 * np.pi)
        inward = phase + (np.arange(lobes) + 0.5) * 2 * np.pi / lobes
        bends = np.roll(inward, int(rng.integers(lobes)))
        hub = sketch.add(rng.normal(0, 8.0 * strength, 2))
        for first, last in ((0, 2), (1, 3)):
            street = Rail(sketch, _no_fill, _width(rng))
            for place, lobe in ((0, first), (4, last)):
                street.put(place, road.station(bends[lobe] + rng.normal(0, 0.04 * strength)))
                way_m = 0.55 * sketch.point(hub) + 0.45 * at(bends[lobe]) + rng.normal(0, 5.0 * strength, 2)
                street.put(1 if place == 0 else 3, sketch.add(way_m))
            street.put(2, hub)
            street.draw(fill_m=np.inf)
        road.draw(fill_m=22.0)
        return sketch

    return _first_sound(rng, draw, extent_m, warp_m=4.0, min_radius_m=24.0)


def _first_sound(
    rng: np.random.Generator,
    draw: Callable[[float], Sketch],
    extent_m: float,
    warp_m: float,
    min_radius_m: float = MIN_RADIUS_M,
) -> RoadGraph:
    """Return the first valid network of ``draw(strength)``, warped, with decreasing strength."""
    faults = []
    for attempt in range(60):
        strength = 0.94**attempt
        sketch = draw(strength)
        points_m = smooth_warp(rng, extent_m, warp_m * strength)(sketch.points_m)
        graph = graph_of_roads(points_m, sketch.roads)
        fault = fault_of(graph, extent_m / 2 - 0.6 * EDGE_MARGIN_M, min_radius_m)
        if fault is None:
            return graph
        faults.append(fault)
    raise ValueError(f"extent_m: no sound street network found for {extent_m} ({faults[-1]})")


def _no_fill(t: float) -> NDArray[np.float64]:
    raise AssertionError("this rail has all its stations set")


def _width(rng: np.random.Generator) -> float:
    return float(np.round(rng.uniform(7.0, 8.4), 1))


def _spaced(rng: np.random.Generator, low: float, high: float, least: float, most: float) -> NDArray[np.float64]:
    """Return places between ``low`` and ``high``, ``least`` to ``most`` apart on average, jittered."""
    span = high - low
    count = int(rng.integers(max(1, int(span // most)), max(2, int(span // least) + 1)))
    pitch = span / count
    return low + (np.arange(count) + 0.5 + rng.uniform(-0.22, 0.22, count)) * pitch


def _lines(rng: np.random.Generator, half_m: float, strength: float) -> NDArray[np.float64]:
    """Return the places of two to four parallel streets inside a ring of ``half_m``."""
    count = int(rng.integers(2, 4)) if half_m < 190.0 else int(2 * half_m // 95.0)
    pitch = 2 * half_m / (count + 1)
    return -half_m + pitch * (np.arange(count) + 1 + 0.13 * strength * rng.uniform(-1, 1, count))


def _row(sketch: Sketch, ring_road: Rail, height_m: float, half_m: float, exponent: float, width_m: float) -> Rail:
    """Return a street across the ring at one height, which other streets can join."""
    end_m = height_on_superellipse(height_m, half_m, exponent)
    row = Rail(sketch, lambda x_m: np.array([x_m, height_m]), width_m)
    for x_m in (-end_m, end_m):
        row.put(x_m, ring_road.station(float(np.arctan2(height_m, x_m))))
    return row


def _join(rows: list[Rail], ring_road: Rail, index: int, x_m: float, half_m: float, exponent: float) -> int:
    """Return the point where a lane at ``x_m`` joins row ``index``, or the ring beyond the outermost rows."""
    if 0 <= index < len(rows):
        return rows[index].station(x_m, SNAP_M)
    y_m = height_on_superellipse(x_m, half_m, exponent) * (-1.0 if index < 0 else 1.0)
    return ring_road.station(float(np.arctan2(y_m, x_m)), SNAP_M)
