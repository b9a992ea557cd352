"""Shapes of a person's head with neck, hair and what is worn on it, as shares of stature."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.meshes.person_parts import (
    Body,
    HairStyle,
    Headwear,
    Patches,
    SmoothShape,
    Station,
    joined,
    loft,
    rings,
)

HEAD_STATIONS: list[Station] = [
    (0.1520, -0.002, 0.020, 0.024, 0.0200),
    (0.1350, 0.000, 0.048, 0.050, 0.0410),
    (0.1180, 0.000, 0.0540, 0.0560, 0.0440),
    (0.0870, 0.000, 0.0545, 0.0540, 0.0435),
    (0.0720, 0.001, 0.0545, 0.0500, 0.0425),
    (0.0590, 0.002, 0.0550, 0.0460, 0.0405),
    (0.0480, 0.003, 0.0525, 0.0420, 0.0385),
    (0.0370, 0.004, 0.0510, 0.0360, 0.0345),
    (0.0260, 0.006, 0.0460, 0.0300, 0.0270),
]
"""From crown to chin, above the joint of the head at the base of the neck."""

HEAD_FORWARD = 0.012
"""Of the head's middle before that joint, share of stature."""
BARE_CROWN_Z = 0.122
"""Height above which receding hair leaves the head bare."""

_EDGES_Z = {
    "short": [0.128, 0.127, 0.112, 0.078, 0.075, 0.050, 0.044],
    "long": [0.128, 0.126, 0.105, 0.060, 0.040, 0.030, 0.026],
    "bun": [0.129, 0.127, 0.113, 0.084, 0.078, 0.052, 0.044],
    "receding": [0.140, 0.138, 0.122, 0.082, 0.076, 0.050, 0.044],
    "bald": [0.200, 0.200, 0.200, 0.200, 0.200, 0.200, 0.200],
    "cap": [0.108, 0.108, 0.106, 0.100, 0.097, 0.094, 0.092],
    "beanie": [0.108, 0.106, 0.098, 0.078, 0.070, 0.066, 0.064],
    "scarf": [0.124, 0.121, 0.092, 0.030, 0.000, 0.000, 0.000],
}
"""Heights of lower edges at 0, 30, 55, 75, 95, 130 and 180 degrees from straight ahead."""
_EDGE_OF: dict[str, str] = {
    "cropped": "short",
    "curly": "short",
    "bob": "long",
    "ponytail": "bun",
    "hat": "cap",
}
_THICKNESS: dict[str, float] = {
    "short": 0.0035,
    "long": 0.006,
    "bald": 0.0,
    "cropped": 0.0012,
    "receding": 0.002,
    "bob": 0.007,
    "bun": 0.0025,
    "ponytail": 0.0025,
    "curly": 0.016,
}
_WORN_THICKNESS: dict[str, float] = {"cap": 0.003, "beanie": 0.005, "hat": 0.006, "scarf": 0.005}


def head(body: Body, patches: Patches, hair: HairStyle, worn: Headwear | None) -> SmoothShape:
    """Return head, neck, ears and nose, hair that stands off from the head where it grows, and what is worn over it."""
    unit_m = body.bones.stature * body.figure.head
    ring = rings(HEAD_STATIONS, 12, 1.0, 2.1)
    flat = worn in ("beanie", "scarf")
    _raise(ring, hair, min(_THICKNESS[hair], 0.003) if flat else _THICKNESS[hair])
    if worn is not None:
        _raise(ring, worn, _WORN_THICKNESS[worn])
    _raise_nose(ring)
    ring[..., 0] += HEAD_FORWARD
    skull = loft(unit_m * ring, 0.003 * unit_m, 0.002 * unit_m, patches["head"], upright=True)
    neck_stations = [(0.060, 0.004, 0.028, 0.030, 0.0290), (-0.022, -0.003, 0.036, 0.038, 0.0380)]
    around = rings(neck_stations, 6, body.bones.stature)
    around[..., :2] *= 0.5 + 0.5 * body.figure.shoulders
    parts = [skull, loft(around, 0.0, 0.0, patches["neck"])]
    if worn != "scarf":
        parts += [_ear(unit_m, patches, 1.0), _ear(unit_m, patches, -1.0)]
        parts += _hanging(unit_m, patches, hair)
    if worn == "cap":
        parts.append(_peak(unit_m, patches))
    elif worn == "hat":
        parts.append(_brim(unit_m, patches))
    elif worn == "scarf":
        parts.append(_drape(unit_m, patches))
    return joined(parts)


def edge_z(azimuth_rad: NDArray[np.float64], edge: str) -> NDArray[np.float64]:
    """Return the height of the lower edge of hair or headwear above the joint of the head, share of stature.

    Args:
        azimuth_rad: from straight ahead, either way.
        edge: a style of hair or a kind of headwear.
    """
    at = np.abs((azimuth_rad + np.pi) % (2.0 * np.pi) - np.pi)
    return np.interp(at, np.deg2rad([0, 30, 55, 75, 95, 130, 180]), _EDGES_Z[_EDGE_OF.get(edge, edge)])


def _raise(ring: NDArray[np.float64], edge: str, thickness: float) -> None:
    """Move the points (S, N, 3) above an edge outwards from the middle of the head, in shares of stature."""
    covered = np.clip((ring[..., 2] - edge_z(np.arctan2(ring[..., 1], ring[..., 0]), edge)) / 0.008 + 0.5, 0.0, 1.0)
    away = ring - np.array([0.0, 0.0, 0.09])
    ring += (thickness * covered)[..., None] * away / np.linalg.norm(away, axis=2, keepdims=True)


def _raise_nose(ring: NDArray[np.float64]) -> None:
    """Move the points straight ahead, and those under the cheekbones beside them, into a nose and eye sockets."""
    front = ring.shape[1] // 2
    ring[:, front, 0] += np.interp(ring[:, front, 2], [0.050, 0.059, 0.073, 0.087, 0.1], [0, 0.0125, 0.008, 0.001, 0])
    for side in (front - 1, front + 1):
        ring[:, side, 0] -= np.interp(ring[:, side, 2], [0.059, 0.073, 0.087, 0.1], [0, 0.003, 0.0035, 0.0])


def _ear(unit_m: float, patches: Patches, side: float) -> SmoothShape:
    stations = [(0.0860, -0.004, 0.007, 0.009, 0.0050), (0.0650, -0.001, 0.006, 0.007, 0.0045)]
    ring = rings(stations, 4, unit_m)
    ring += unit_m * np.array([HEAD_FORWARD, side * 0.0455, 0.0])
    return loft(ring, 0.004 * unit_m, 0.004 * unit_m, patches["ear"])


def _hanging(unit_m: float, patches: Patches, hair: HairStyle) -> list[SmoothShape]:
    """Return hair that falls behind the ears or is tied at the back of the head; none for short hair."""
    falling = [
        (0.115, -0.012, 0.026, 0.047, 0.0410),
        (0.088, -0.012, 0.024, 0.0515, 0.0490),
        (0.050, -0.013, 0.018, 0.0500, 0.0505),
        (0.010, -0.018, 0.016, 0.0430, 0.0490),
        (-0.030, -0.030, 0.012, 0.0300, 0.0420),
    ]
    knot = [
        (0.128, -0.058, 0.012, 0.014, 0.0150),
        (0.115, -0.062, 0.018, 0.020, 0.0230),
        (0.100, -0.062, 0.018, 0.020, 0.0230),
        (0.088, -0.058, 0.012, 0.012, 0.0140),
    ]
    tail = [
        (0.112, -0.056, 0.012, 0.016, 0.0160),
        (0.095, -0.066, 0.014, 0.017, 0.0190),
        (0.040, -0.068, 0.012, 0.014, 0.0170),
        (-0.030, -0.062, 0.007, 0.008, 0.0090),
    ]
    stations = {"long": falling, "bob": falling[:4], "bun": knot, "ponytail": tail}.get(hair)
    if stations is None:
        return []
    ring = rings(stations, 8, unit_m, 2.4) + unit_m * np.array([HEAD_FORWARD, 0.0, 0.0])
    return [loft(ring, 0.004 * unit_m, 0.004 * unit_m, patches["hair"])]


def _peak(unit_m: float, patches: Patches) -> SmoothShape:
    """Return the peak of a cap."""
    stations = [(0.1130, 0.040, 0.050, 0.030, 0.0370), (0.1080, 0.040, 0.053, 0.030, 0.0400)]
    ring = rings(stations, 6, unit_m, 2.4)
    ring[..., 2] -= 0.15 * np.maximum(ring[..., 0] - 0.06 * unit_m, 0.0)
    ring[..., 0] += HEAD_FORWARD * unit_m
    return loft(ring, 0.001 * unit_m, 0.001 * unit_m, patches["cap"])


def _brim(unit_m: float, patches: Patches) -> SmoothShape:
    """Return the brim of a hat."""
    stations = [(0.1050, 0.000, 0.088, 0.090, 0.0800), (0.0990, 0.000, 0.088, 0.090, 0.0800)]
    ring = rings(stations, 12, unit_m)
    ring[..., 0] += HEAD_FORWARD * unit_m
    return loft(ring, 0.001 * unit_m, 0.001 * unit_m, patches["cap"])


def _drape(unit_m: float, patches: Patches) -> SmoothShape:
    """Return the lower part of a headscarf, around the neck."""
    stations = [
        (0.050, -0.010, 0.040, 0.050, 0.0440),
        (0.020, -0.010, 0.048, 0.050, 0.0480),
        (-0.005, -0.010, 0.056, 0.054, 0.0620),
        (-0.035, -0.012, 0.062, 0.058, 0.0820),
    ]
    ring = rings(stations, 10, unit_m, 2.2) + unit_m * np.array([HEAD_FORWARD, 0.0, 0.0])
    return loft(ring, 0.004 * unit_m, -0.01 * unit_m, patches["cap"])
