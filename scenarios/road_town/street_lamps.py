"""Street lamps of a town: where they stand, and the light that they give."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from scenarios.road_town.layout import RoadGraph, StreetLamp
from scenarios.road_town.road_map import road_area
from sim.meshes.lamp_post import HEIGHT_M, REACH_M

_APART_M = 26.0
"""Along a street, on alternate sides: three to four times the height of the lamps, as in residential streets."""
_FROM_KERB_M = 0.6
_CLEAR_M = 7.0
"""Distance of the first lamp from a street's ends."""


def place_lamps(graph: RoadGraph) -> tuple[StreetLamp, ...]:
    """Return the lamps along all streets, on the pavements, their arms over the carriageway."""
    area = road_area(graph)
    shapely.prepare(area)
    lamps = []
    for number, street in enumerate(graph.streets):
        along = np.gradient(street.centre_m, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        arc_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(street.centre_m, axis=0), axis=1))])
        room_m = arc_m[-1] - 2.0 * _CLEAR_M
        if room_m < 0.0:
            continue
        count = 1 + round(room_m / _APART_M)
        places = _CLEAR_M + room_m * (np.arange(count) + 0.5) / count
        for k, index in enumerate(np.searchsorted(arc_m, places).tolist()):
            side = 1.0 if (k + number) % 2 else -1.0
            left = side * np.array([-along[index, 1], along[index, 0]])
            x, y = (street.centre_m[index] + (0.5 * street.width_m + _FROM_KERB_M) * left).tolist()
            # Not in the carriageway of another street that meets here.
            if not shapely.intersects_xy(area, x, y):
                lamps.append(StreetLamp((x, y), float(np.arctan2(-left[1], -left[0]))))
    return tuple(lamps)


def lamp_heads_m(lamps: tuple[StreetLamp, ...]) -> NDArray[np.float64]:
    """Return the places (K, 3) from which lamps shine."""
    return np.array(
        [
            (
                lamp.centre_m[0] + REACH_M * np.cos(lamp.yaw_rad),
                lamp.centre_m[1] + REACH_M * np.sin(lamp.yaw_rad),
                HEIGHT_M,
            )
            for lamp in lamps
        ]
    ).reshape(-1, 3)
