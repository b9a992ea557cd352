"""The map of a town as plain data: streets as a graph of curves, and the objects beside them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim.meshes.varied_house import HouseStyle

ROAD, OTHER, BUILDING = 0, 1, 2
"""Ground classes of ``ground.class_map`` (paper A.3: road, other, building)."""


@dataclass(frozen=True, eq=False)
class Street:
    """One edge of the road graph: a smooth curve between two nodes.

    Attributes:
        start, end: node indices.
        centre_m: (M, 2) points of the centre line, at most 1 m apart, from start to end.
        width_m: kerb to kerb, two lanes, whose centres are width / 4 beside the centre line.
    """

    start: int
    end: int
    centre_m: NDArray[np.float64]
    width_m: float


@dataclass(frozen=True, eq=False)
class RoadGraph:
    """Crossings and the streets between them.

    Attributes:
        nodes_m: (K, 2).
        streets: edges; traffic uses every street in both directions.
        traffic_side: the side of the centre line on which it keeps, seen in its direction.
        lanes_m: (street, whether it is driven from its start) -> (M, 2), as ``route`` has drawn it; routes share lanes.
    """

    nodes_m: NDArray[np.float64]
    streets: tuple[Street, ...]
    traffic_side: Literal["right", "left"] = "right"
    lanes_m: dict[tuple[int, bool], NDArray[np.float64]] = field(default_factory=dict, init=False)

    @property
    def right_sign(self) -> float:
        """+1 where traffic keeps right, -1 where it keeps left."""
        return 1.0 if self.traffic_side == "right" else -1.0


@dataclass(frozen=True)
class Building:
    """A box with a roof.

    Attributes:
        centre_m: ground-plan centre (x, y).
        size_m: length, width, height to the eaves.
        yaw_rad: of the length axis.
        roof: ``flat``, ``gable`` or ``hip``.
        wall_rgb, roof_rgb: sRGB 0-255.
        style: of a ``varied_house``, None for a ``house``.
        model: ``house``, or a file, see ``sim.meshes.file``, whose bounds the box is.
    """

    centre_m: tuple[float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float
    roof: str
    wall_rgb: tuple[int, int, int]
    roof_rgb: tuple[int, int, int]
    style: HouseStyle | None = None
    model: str = "house"


@dataclass(frozen=True)
class Tree:
    """A tree with a crown of ``radius_m``; its height is two to three times that."""

    centre_m: tuple[float, float]
    radius_m: float


@dataclass(frozen=True)
class StreetLamp:
    """A lamp on the pavement; its arm points along ``yaw_rad``, over the street."""

    centre_m: tuple[float, float]
    yaw_rad: float


@dataclass(frozen=True)
class CarPark:
    """A paved rectangle beside a street, with marked bays and perhaps parked cars.

    Attributes:
        centre_m, size_m, yaw_rad: the rectangle.
        bays: (x, y, yaw) of every bay. taken: whether a car stands in it.
    """

    centre_m: tuple[float, float]
    size_m: tuple[float, float]
    yaw_rad: float
    bays: tuple[tuple[float, float, float], ...]
    taken: tuple[bool, ...]


Rectangle = tuple[tuple[float, float], tuple[float, float], float]
"""Centre, size and yaw of a rectangle on the ground, metres and radians."""


@dataclass(frozen=True)
class Prop:
    """A small thing in a garden or on a pavement.

    Attributes:
        kind: see ``sim.meshes.street_props.KINDS``.
        size_m: along, across, height.
        variant: decides its colour and all that is random about it.
    """

    kind: str
    centre_m: tuple[float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float
    variant: int

    @property
    def rectangle(self) -> Rectangle:
        """The ground that it takes."""
        return self.centre_m, self.size_m[:2], self.yaw_rad


@dataclass(frozen=True)
class Overpass:
    """A way over a street, or a cover over it; cars drive under it.

    Attributes:
        kind: ``footbridge``, ``road``, ``rail`` or ``cover``.
        centre_m, yaw_rad: place over the street's middle, and direction of the deck's length (of a cover: across the
            street).
        start_m, end_m: ends of the level deck on its axis, from the centre.
        width_m: of the deck; of a cover the length along the street.
        under_m, top_m: heights of the deck's lower and upper side.
        solids: what of it stands on the ground: piers, stairs, banks.
        piers_m: places on the axis, from the centre, of a viaduct's piers.
        stairs: of a footbridge: at its start and end, +1 or -1 for stairs down to the left or right of the axis.
    """

    kind: str
    centre_m: tuple[float, float]
    yaw_rad: float
    start_m: float
    end_m: float
    width_m: float
    under_m: float
    top_m: float
    solids: tuple[Rectangle, ...]
    piers_m: tuple[float, ...] = ()
    stairs: tuple[float, ...] = ()

    @property
    def rectangle(self) -> Rectangle:
        """The ground under the deck."""
        middle_m = 0.5 * (self.start_m + self.end_m)
        x = self.centre_m[0] + middle_m * np.cos(self.yaw_rad)
        y = self.centre_m[1] + middle_m * np.sin(self.yaw_rad)
        return (float(x), float(y)), (self.end_m - self.start_m, self.width_m), self.yaw_rad


@dataclass(frozen=True, eq=False)
class Layout:
    """A whole town, centred on the origin.

    Attributes:
        extent_m: side of the square ground.
        graph, buildings, trees, car_parks, lamps: its parts.
        props: hedges, signs and the like. overpasses: bridges and covers over its streets.
        zebras: (street, arc_m) where people cross it; none in a town without people.
    """

    extent_m: float
    graph: RoadGraph
    buildings: tuple[Building, ...]
    trees: tuple[Tree, ...]
    car_parks: tuple[CarPark, ...]
    lamps: tuple[StreetLamp, ...] = ()
    props: tuple[Prop, ...] = ()
    overpasses: tuple[Overpass, ...] = ()
    zebras: tuple[tuple[int, float], ...] = ()
