"""Which fish stand apart in a picture, and which lie together or across each other: from truth, after refraction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.truth import FishTruth
from scenarios.visibility import MOSTLY_SEEN

CONTACT_PX = 2
"""Fish with pixels so near each other, along rows and columns, lie together: no detector can be sure to part them."""
_OFFSETS = tuple(
    (down, right)
    for down in range(CONTACT_PX + 1)
    for right in range(-CONTACT_PX, CONTACT_PX + 1)
    if (down, right) > (0, 0)
)
"""Half of the neighbourhood: a pair of pixels is found from one of the two."""


def together(truth: FishTruth) -> NDArray[np.bool_]:
    """Return (N, N), symmetric: whether two fish have pixels within ``CONTACT_PX`` of each other."""
    count = len(truth.names)
    pairs = np.zeros((count, count), dtype=bool)
    if count == 0:
        return pairs
    index_of = np.full(int(max(truth.instance_map.max(initial=0), truth.instance_id.max())) + 1, -1)
    index_of[truth.instance_id] = np.arange(count)
    # Ids below zero mark what is no object.
    fish = np.where(truth.instance_map >= 0, index_of[np.maximum(truth.instance_map, 0)], -1)
    framed = np.pad(fish, CONTACT_PX, constant_values=-1)
    rows, columns = np.nonzero(framed >= 0)
    here = framed[rows, columns]
    for down, right in _OFFSETS:
        there = framed[rows + down, columns + right]
        other = (there >= 0) & (there != here)
        pairs[here[other], there[other]] = True
    return pairs | pairs.T


def stands_apart(truth: FishTruth, together_with: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (N,) whether at least half of a fish is seen and no other fish lies together with it."""
    return ~together_with.any(axis=1) & (truth.visible_fraction >= MOSTLY_SEEN)


def crossing(truth: FishTruth, together_with: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (N,) whether the fish's centre line crosses that of another fish with which it lies together."""
    crossed = np.zeros(len(truth.names), dtype=bool)
    for pair in np.argwhere(np.triu(together_with)):
        crossed[pair] |= _cross(*truth.centre_line_px[pair])
    return crossed


def _cross(first_px: NDArray[np.float64], second_px: NDArray[np.float64]) -> bool:
    """Return whether two lines (K, 2) and (L, 2) of straight segments cross.

    Segments cross if the ends of each lie on different sides of the other.
    """
    a, b = first_px[:-1, None], first_px[1:, None]
    c, d = second_px[None, :-1], second_px[None, 1:]
    parted = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
    return bool(parted.any())


def _side(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    along, to = b - a, c - a
    return along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]
