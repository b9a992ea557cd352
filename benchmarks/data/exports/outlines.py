"""Masks as polygons and as oriented boxes, in pixels: the first pixel covers 0 to 1 on both axes."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

_LEAST_POINTS = 3


def polygon_of(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return one polygon (P, 2), P >= 3, through the centres of the outermost pixels of a mask (H, W), not empty.

    Parts and holes are joined to one line by the shortest ways between them, walked there and back. Filled by the rule
    of even and odd, with its line drawn, as ``cv2.fillPoly`` does, it is the mask again, and the lines between parts.
    """
    found, _ = cv2.findContours(np.ascontiguousarray(mask, np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    ring, *others = (each[:, 0].astype(np.int64) for each in found)
    while others:
        tree = cKDTree(ring)
        ways = [tree.query(each) for each in others]
        nearest = int(np.argmin([length.min() for length, _ in ways]))
        length, at = ways[nearest]
        begins = int(length.argmin())
        there, here = np.roll(others.pop(nearest), -begins, axis=0), int(at[begins])
        ring = np.concatenate([ring[: here + 1], there, there[:1], ring[here:]])
    ring = _corners_alone(ring)
    return np.concatenate([ring, *[ring[-1:]] * (_LEAST_POINTS - len(ring))]) + 0.5


def _corners_alone(ring: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a closed line (P, 2) without the points at which it goes straight on."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    straight = (before[:, 0] * after[:, 1] == before[:, 1] * after[:, 0]) & ((before * after).sum(axis=1) > 0)
    return ring[~straight]


def oriented_box(mask: NDArray[np.bool_], ahead_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners (4, 2) of the rectangle of least area around the pixels of a mask (H, W), not empty.

    They go round clockwise from the left corner of the side that faces ``ahead_px`` (2,), a direction in the picture;
    of the upper side where that is NaN or 0. One side of that rectangle lies on a side of the convex hull.
    """
    rows, columns = np.nonzero(mask)
    middles = np.stack([columns, rows], axis=1)
    corners = np.concatenate([middles + shift for shift in ((0, 0), (1, 0), (0, 1), (1, 1))]).astype(np.int32)
    hull = cv2.convexHull(corners)[:, 0].astype(np.float64)
    sides = np.roll(hull, -1, axis=0) - hull
    along = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    axes = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)
    places = np.einsum("sak,pk->sap", axes, hull)
    low, high = places.min(axis=2), places.max(axis=2)
    best = int(np.prod(high - low, axis=1).argmin())
    (u, v), middle, half = axes[best], 0.5 * (low + high)[best] @ axes[best], 0.5 * (high - low)[best]
    ahead = ahead_px if np.isfinite(ahead_px).all() and ahead_px.any() else np.array([0.0, -1.0])
    facing = [(u, half[0], half[1]), (v, half[1], half[0]), (-u, half[0], half[1]), (-v, half[1], half[0])]
    front, reach, aside = max(facing, key=lambda each: float(each[0] @ ahead))
    forward, right = reach * front, aside * np.array([-front[1], front[0]])
    return middle + np.array([forward - right, forward + right, -forward + right, -forward - right])
