"""Floor plans: a corridor, a hall and a yard behind its door, drawn anew for every episode.

World frame: x runs from the corridor through the hall (one corner at the origin) into the yard, z is up.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

PLACES = ("corridor", "hall", "door", "yard")
WALL_M = 0.3
"""Thickness of the wall between hall and yard."""
_CLEARANCE_M = {"corridor": 0.45, "hall": 1.1, "yard": 1.8}
"""Distance of people from walls; objects along the walls of hall and yard stand within it."""
_BESIDE_DOOR_M = 0.45
_CLEAR_M, _CORNER_M = 0.2, 0.35
"""Distance from the island of straight ways, so that rounded corners do not reach into it, and of the corners of ways
around it.
"""
_APPROACH_M = 0.9
"""Paths lead straight through openings from this distance before to this distance behind."""


@dataclass(frozen=True, slots=True)
class Area:
    """A rectangle of ground, sides along x and y, metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    def shrunk(self, margin_m: float) -> Area:
        """Return the area without a margin at its border."""
        return Area(self.x0 + margin_m, self.y0 + margin_m, self.x1 - margin_m, self.y1 - margin_m)

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Its corners, counter-clockwise."""
        return (self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1)

    def holds(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which points (..., 2) lie in it."""
        x, y = points_m[..., 0], points_m[..., 1]
        return (x >= self.x0) & (x <= self.x1) & (y >= self.y0) & (y <= self.y1)

    def draw(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw a point (2,) in it."""
        return np.array([rng.uniform(self.x0, self.x1), rng.uniform(self.y0, self.y1)])


class RoomPlan(Protocol):
    """Walls of a plan, for drawings."""

    @property
    def rooms(self) -> dict[str, Area]:
        """Rooms by name."""
        ...

    @property
    def openings(self) -> tuple[Area, ...]:
        """Gaps in the walls between rooms, as deep along x as the wall."""
        ...


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """Rooms in a row, and their openings.

    Attributes:
        corridor, hall, yard: the rooms.
        corridor_height_m, hall_height_m, facade_height_m, far_height_m: of the ceilings, of the building's facade on
            the yard, and of the facade across.
        passage: opening between corridor and hall, through a wall without thickness.
        door: opening between hall and yard.
        opening_height_m: of both.
        island: part of the hall's free area that furniture stands in; None for none.
        walked: rooms in which people walk, in their order along x.
    """

    corridor: Area
    hall: Area
    yard: Area
    corridor_height_m: float
    hall_height_m: float
    facade_height_m: float
    far_height_m: float
    passage: Area
    door: Area
    opening_height_m: float
    island: Area | None = None
    walked: tuple[str, ...] = ("corridor", "hall", "yard")

    @property
    def rooms(self) -> dict[str, Area]:
        """The rooms by name, in their order along x."""
        return {"corridor": self.corridor, "hall": self.hall, "yard": self.yard}

    @property
    def openings(self) -> tuple[Area, Area]:
        """The openings between rooms."""
        return self.passage, self.door

    def room_of(self, point_m: NDArray[np.float64]) -> str:
        """Return the room of a point (2,); a point in an opening belongs to the nearer room."""
        if point_m[0] < 0.0:
            return "corridor"
        return "hall" if point_m[0] < self.door.x0 + 0.5 * WALL_M else "yard"

    def place_of(self, point_m: NDArray[np.float64]) -> str:
        """Return the place of a point (2,), one of ``PLACES``; the door reaches one metre around its opening."""
        near = self.door.shrunk(-1.0)
        return "door" if len(self.walked) > 1 and bool(near.holds(point_m)) else self.room_of(point_m)

    def free_area(self, room: str) -> Area:
        """Return the area of a room where people walk."""
        return self.rooms[room].shrunk(_CLEARANCE_M[room])

    def draw_place(self, room: str, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw a place (2,) in the free area of a room, clear of its furniture."""
        place_m = self.free_area(room).draw(rng)
        while not self.is_clear(place_m, place_m):
            place_m = self.free_area(room).draw(rng)
        return place_m

    def is_clear(self, from_m: NDArray[np.float64], to_m: NDArray[np.float64]) -> bool:
        """Return whether a straight way between two places (2,) keeps clear of the island."""
        return self.island is None or not _crosses(from_m, to_m, self.island.shrunk(-_CLEAR_M))

    def around(self, from_m: NDArray[np.float64], to_m: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Return the corners (2,) of the shortest way to a place around the island, the place last."""
        if self.island is None or self.is_clear(from_m, to_m):
            return [to_m]
        area = self.island.shrunk(-_CORNER_M)
        corners = [np.array([x, y]) for x, y in area.corners]
        one = [[corner] for corner in corners]
        two = [[corners[k], corners[(k + step) % 4]] for k in range(4) for step in (1, 3)]
        whole = [[from_m, *way, to_m] for way in (*one, *two)]
        clear = [way for way in whole if all(self.is_clear(a, b) for a, b in pairwise(way))]
        if not clear:
            return [to_m]
        return min(clear, key=lambda way: sum(float(np.linalg.norm(b - a)) for a, b in pairwise(way)))[1:]

    @property
    def free_parts(self) -> tuple[Area, ...]:
        """Areas where people and the robot can be: the free areas of rooms, and lanes through openings."""
        lanes = (
            Area(gap.x0 - before_m, gap.y0 + _BESIDE_DOOR_M, gap.x1 + behind_m, gap.y1 - _BESIDE_DOOR_M)
            for gap, before_m, behind_m in (
                (self.passage, _CLEARANCE_M["corridor"], _CLEARANCE_M["hall"]),
                (self.door, _CLEARANCE_M["hall"], _CLEARANCE_M["yard"]),
            )
        )
        rooms = (self.free_area(room) for room in self.rooms)
        if self.island is None:
            return (*rooms, *lanes)
        corridor, hall, yard = rooms
        return (corridor, *_strips_around(hall, self.island), yard, *lanes)

    @property
    def free_m(self) -> NDArray[np.float64]:
        """``free_parts`` as (P, 4) rectangles x0, y0, x1, y1."""
        return np.array([[part.x0, part.y0, part.x1, part.y1] for part in self.free_parts])

    @property
    def openings_m(self) -> NDArray[np.float64]:
        """``openings`` as (2, 4) rectangles x0, y0, x1, y1."""
        return np.array([[gap.x0, gap.y0, gap.x1, gap.y1] for gap in self.openings])

    def is_free(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether a person or the robot can be at points (..., 2)."""
        free = np.zeros(points_m.shape[:-1], dtype=np.bool_)
        for part in self.free_parts:
            free |= part.holds(points_m)
        return free

    def way(self, stops_m: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Return corners (M, 2) of a path from stop to stop (N, 2) through the openings.

        The place within each opening is drawn anew.
        """
        rooms = list(self.rooms)
        corners = [stops_m[0]]
        for start, end in pairwise(stops_m):
            here, there = rooms.index(self.room_of(start)), rooms.index(self.room_of(end))
            step = 1 if there > here else -1
            for room in range(here, there, step):
                opening = (self.passage, self.door)[min(room, room + step)]
                y_m = rng.uniform(opening.y0 + 1.2 * _BESIDE_DOOR_M, opening.y1 - 1.2 * _BESIDE_DOOR_M)
                ends_m = (opening.x0 - _APPROACH_M, opening.x1 + _APPROACH_M)
                corners += [np.array([x_m, y_m]) for x_m in ends_m[::step]]
            corners.append(end)
        return np.array([corners[0], *(corner for a, b in pairwise(corners) for corner in self.around(a, b))])


def _strips_around(area: Area, hole: Area) -> tuple[Area, Area, Area, Area]:
    """Return the largest rectangles of an area beside a hole."""
    return (
        Area(area.x0, area.y0, hole.x0, area.y1),
        Area(hole.x1, area.y0, area.x1, area.y1),
        Area(area.x0, area.y0, area.x1, hole.y0),
        Area(area.x0, hole.y1, area.x1, area.y1),
    )


def _crosses(from_m: NDArray[np.float64], to_m: NDArray[np.float64], area: Area) -> bool:
    """Return whether a straight line between two places (2,) meets an area, by Liang and Barsky's method."""
    first, last = 0.0, 1.0
    for start, step, low, high in (
        (float(from_m[0]), float(to_m[0] - from_m[0]), area.x0, area.x1),
        (float(from_m[1]), float(to_m[1] - from_m[1]), area.y0, area.y1),
    ):
        if abs(step) < 1e-12:
            if not low < start < high:
                return False
            continue
        enters, leaves = sorted(((low - start) / step, (high - start) / step))
        first, last = max(first, enters), min(last, leaves)
    return first < last


def draw_floor_plan(rng: np.random.Generator) -> FloorPlan:
    """Draw sizes of rooms and places of openings."""
    hall = Area(0.0, 0.0, rng.uniform(9.0, 12.0), rng.uniform(8.0, 10.0))
    width_m, length_m = rng.uniform(2.3, 3.0), rng.uniform(14.0, 20.0)
    middle_m = rng.uniform(2.0 + 0.5 * width_m, hall.y1 - 2.0 - 0.5 * width_m)
    corridor = Area(-length_m, middle_m - 0.5 * width_m, 0.0, middle_m + 0.5 * width_m)
    passage_m = rng.uniform(1.8, 2.2)
    door_m, door_middle_m = rng.uniform(1.8, 2.4), rng.uniform(2.5, hall.y1 - 2.5)
    outside_m = hall.x1 + WALL_M
    yard_m = (rng.uniform(18.0, 24.0), rng.uniform(20.0, 26.0))
    yard_y0 = door_middle_m - rng.uniform(0.4, 0.6) * yard_m[1]
    return FloorPlan(
        corridor=corridor,
        hall=hall,
        yard=Area(outside_m, yard_y0, outside_m + yard_m[0], yard_y0 + yard_m[1]),
        corridor_height_m=rng.uniform(2.4, 2.8),
        hall_height_m=rng.uniform(3.2, 4.0),
        facade_height_m=rng.uniform(5.5, 8.0),
        far_height_m=rng.uniform(4.0, 7.0),
        passage=Area(0.0, middle_m - 0.5 * passage_m, 0.0, middle_m + 0.5 * passage_m),
        door=Area(hall.x1, door_middle_m - 0.5 * door_m, outside_m, door_middle_m + 0.5 * door_m),
        opening_height_m=2.25,
    )
