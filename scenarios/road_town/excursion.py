"""Excursions off the road: a route bent aside over grass or paving, clear of houses, trees and parked cars."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import Layout
from scenarios.road_town.route import POINT_SPACING_M, Passage, Route, resample, smooth_heading
from scenarios.road_town.smooth import smooth_step

_CLEARANCE_M = 1.8
_LEAVE_OVER_M = 13.0
_TRIES = 150


@dataclass(frozen=True, slots=True)
class Excursion:
    """A stretch of a route that is off the road.

    Attributes:
        leave_m, return_m: arc lengths on the bent route where it leaves the road, and where it is back.
    """

    leave_m: float
    return_m: float


def with_excursion(
    route: Route,
    layout: Layout,
    rng: np.random.Generator,
    *,
    between_m: tuple[float, float],
    aside_m: tuple[float, float],
    along_m: tuple[float, float],
    clears: bool = True,
) -> tuple[Route, Layout, Excursion | None]:
    """Bend a route off the road where the fewest obstacles stand, and remove those: trees, at most one house.

    Args:
        between_m: arc lengths between which the excursion lies.
        aside_m: range of the sideways distance from the lane.
        along_m: range of the distance driven off the road.
        clears: False: only where nothing has to be removed.

    Returns:
        The bent route, the layout without the obstacles, and the excursion; or the same route and layout and None if
        there is no room.
    """
    obstacles = _Obstacles(layout)
    arc = np.arange(len(route.points_m), dtype=float) * POINT_SPACING_M
    best: tuple[float, _Hits, NDArray[np.float64], float, float] | None = None
    for _ in range(_TRIES):
        leave = float(rng.uniform(*between_m))
        along = float(rng.uniform(*along_m))
        aside = float(rng.uniform(*aside_m)) * (1 if rng.integers(2) else -1)
        # To the other side, the route first crosses the opposite lane.
        side = layout.graph.right_sign
        aside += 3.5 * side if aside * side > 0 else 0.0
        if leave + along > between_m[1] or any(
            p.enter_m - 2 < leave + along and p.leave_m + 2 > leave for p in route.passages
        ):
            continue
        share = aside_share(arc, leave, along)
        left = np.column_stack([-np.sin(route.heading_rad), np.cos(route.heading_rad)])
        bent = route.points_m + (aside * share)[:, None] * left
        off = share > 0.05
        hits = obstacles.hits(bent[off])
        if hits.parked or len(hits.buildings) > 1 or np.abs(bent[off]).max() > 0.45 * layout.extent_m:
            continue
        cost = 10.0 * len(hits.buildings) + len(hits.trees)
        if (clears or cost == 0) and (best is None or cost < best[0]):
            best = cost, hits, bent, leave, leave + along
        if cost == 0:
            break
    if best is None:
        return route, layout, None
    _, hits, bent, leave, back = best
    cleared = replace(
        layout,
        buildings=tuple(b for k, b in enumerate(layout.buildings) if k not in hits.buildings),
        trees=tuple(t for k, t in enumerate(layout.trees) if k not in hits.trees),
    )
    bent_route, excursion = _rebuilt(route, bent, leave, back)
    return bent_route, cleared, excursion


def aside_share(
    arc_m: NDArray[np.float64], leave_m: float | NDArray[np.float64], along_m: float | NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return an excursion's sideways distance at arc lengths, as a share (0-1) of its largest.

    It is a smooth step out and one back.

    Args:
        leave_m: arc length where it leaves the road.
        along_m: distance from there to where it is back.
    """
    back_m = arc_m - leave_m - along_m + _LEAVE_OVER_M
    return smooth_step((arc_m - leave_m) / _LEAVE_OVER_M) - smooth_step(back_m / _LEAVE_OVER_M)


def _rebuilt(route: Route, bent: NDArray[np.float64], leave_m: float, return_m: float) -> tuple[Route, Excursion]:
    points, arc = resample(bent)

    def moved(old_m: float) -> float:
        return float(np.interp(old_m, np.arange(len(bent)) * POINT_SPACING_M, arc))

    passages = tuple(Passage(p.node, moved(p.enter_m), moved(p.leave_m), p.turn_rad) for p in route.passages)
    return Route(points, smooth_heading(points), passages), Excursion(moved(leave_m), moved(return_m))


@dataclass(frozen=True, slots=True)
class _Hits:
    """Obstacles of a path: indices of buildings and trees, and whether a parked car is among them."""

    buildings: frozenset[int]
    trees: frozenset[int]
    parked: bool


class _Obstacles:
    """Buildings, parked cars and trees of a town."""

    def __init__(self, layout: Layout) -> None:
        boxes = [(b.centre_m, b.size_m[:2], b.yaw_rad) for b in layout.buildings]
        self._buildings = len(boxes)
        for park in layout.car_parks:
            for (x, y, yaw), taken in zip(park.bays, park.taken, strict=True):
                if taken:
                    boxes.append(((x, y), (5.0, 2.2), yaw))
        self._centre = np.array([box[0] for box in boxes]).reshape(-1, 2)
        self._half = 0.5 * np.array([box[1] for box in boxes]).reshape(-1, 2)
        yaws = np.array([box[2] for box in boxes])
        self._axis = np.column_stack([np.cos(yaws), np.sin(yaws)])
        self._trees = np.array([tree.centre_m for tree in layout.trees]).reshape(-1, 2)

    def hits(self, points_m: NDArray[np.float64]) -> _Hits:
        """Return the obstacles within ``_CLEARANCE_M`` of any of the points (M, 2)."""
        offset = points_m[:, None] - self._centre[None]
        lengthwise = np.einsum("mbk,bk->mb", offset, self._axis)
        across = offset[..., 1] * self._axis[:, 0] - offset[..., 0] * self._axis[:, 1]
        outside = np.maximum(np.abs(np.stack([lengthwise, across], axis=-1)) - self._half, 0.0)
        near_boxes = np.flatnonzero((np.linalg.norm(outside, axis=-1) < _CLEARANCE_M).any(axis=0))
        tree_distance = np.linalg.norm(points_m[:, None] - self._trees[None], axis=-1)
        return _Hits(
            frozenset(int(k) for k in near_boxes if k < self._buildings),
            frozenset(np.flatnonzero((tree_distance < _CLEARANCE_M).any(axis=0)).tolist()),
            bool((near_boxes >= self._buildings).any()),
        )
