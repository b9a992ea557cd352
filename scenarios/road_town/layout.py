"""The map of a town as plain data: streets as a graph of curves, and the objects beside them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

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
    """

    centre_m: tuple[float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float
    roof: str
    wall_rgb: tuple[int, int, int]
    roof_rgb: tuple[int, int, int]


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


@dataclass(frozen=True, eq=False)
class Layout:
    """A whole town, centred on the origin.

    Attributes:
        extent_m: side of the square ground.
        graph, buildings, trees, car_parks, lamps: its parts.
    """

    extent_m: float
    graph: RoadGraph
    buildings: tuple[Building, ...]
    trees: tuple[Tree, ...]
    car_parks: tuple[CarPark, ...]
    lamps: tuple[StreetLamp, ...] = ()
