"""Places where cars have parked, and when they are left.

Sun and rain do not reach the ground below a car: once it has driven off, that differs from all that was known of the
place, and would be found as one more object that stands there. A car that stood there since before the start leaves a
place behind that differs from the background because the background shows the car.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.mark import Mark
from trackers.site.reading import Picture

_RATE = 0.3
"""By which the appearance of what stands is followed: it cools, and clouds pass."""
_CHANGED, _CHANGED_SHARE = 6.0, 0.6
"""Deviations of the noise by which a pixel shows something else, and the share of a place from which it is left."""
_LEAVES = 6
"""Pictures until it has surely driven off."""
_RIM_PX = (-4, -4, 4, 4)
"""Added to a place: the shade about the car."""
_MORE_EDGES = 1.4
"""Factor by which the background must have more edges: a car that stood there before it was found has as many."""
_OUTLINE_PX = (-2, -2, 2, 2)
"""Added to a region, so that its outline lies inside."""


@dataclass(eq=False)
class _Place:
    """``box`` (4,) whole pixels, ``seen`` what they show beyond the low-rank background, counts.

    ``leaves``: pictures until its car has surely driven off; None while it stands.
    """

    box: tuple[int, int, int, int]
    seen: Picture
    leaves: int | None = None


class Parked:
    """The places of parked cars."""

    def __init__(self) -> None:
        """Begin with none."""
        self._places: dict[int, _Place] = {}

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(self._places)

    def look(self, parked: Iterable[Mark], left: Picture) -> None:
        """Take in how parked cars look on a picture less its low-rank background (H, W)."""
        for mark in parked:
            box = _within(mark.seen_px, left.shape)
            x0, y0, x1, y1 = box
            if mark.identity not in self._places:
                self._places[mark.identity] = _Place(box, left[y0:y1, x0:x1].copy())
        for place in self._places.values():
            x0, y0, x1, y1 = place.box
            place.seen += _RATE * (left[y0:y1, x0:x1] - place.seen)

    def left(self, left: Picture, noise: Picture) -> Iterator[tuple[int, int, int, int]]:
        """Yield the boxes with a rim, in pixels, of places that show something else, until their cars are gone.

        Args:
            left: (H, W) counts beyond the low-rank background. noise: (H, W) its standard deviation.
        """
        for identity, place in list(self._places.items()):
            x0, y0, x1, y1 = place.box
            changed = np.abs(left[y0:y1, x0:x1] - place.seen) > _CHANGED * noise[y0:y1, x0:x1]
            if place.leaves is None and changed.mean() > _CHANGED_SHARE:
                place.leaves = _LEAVES
            if place.leaves is not None:
                yield with_rim(place.box, left.shape)
                place.leaves -= 1
                if place.leaves == 0:
                    del self._places[identity]


def shows_background_behind(picture: Picture, background: Picture, noise: Picture, box_xyxy: NDArray) -> bool:
    """Return whether something has left a place, rather than come: the background has more edges there.

    ``E = mean (d/dx)^2 + mean (d/dy)^2`` over the place, by central differences, of which noise makes ``4 noise^2``.

    Args:
        picture, background: (H, W) counts. noise: (H, W) standard deviation of the picture.
        box_xyxy: (4,) place, pixels.
    """
    x0, y0, x1, y1 = _within(np.add(box_xyxy, _OUTLINE_PX), picture.shape)
    now, before = picture[y0:y1, x0:x1], background[y0:y1, x0:x1]
    return _edges(before) > _MORE_EDGES * max(_edges(now) - 4.0 * float((noise[y0:y1, x0:x1] ** 2).mean()), 0.0)


def _edges(part: Picture) -> float:
    along, down = part[:, 2:] - part[:, :-2], part[2:] - part[:-2]
    return float((along**2).mean() + (down**2).mean()) if along.size and down.size else 0.0


def with_rim(box_xyxy: NDArray | tuple[int, ...], shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return a place with the shade about it, in whole pixels inside a picture of ``shape``."""
    return _within(np.add(box_xyxy, _RIM_PX), shape)


def _within(box_xyxy: NDArray, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return a box in whole pixels inside a picture of ``shape``, at least one pixel large."""
    x0, y0 = np.clip(np.floor(box_xyxy[:2]), 0, np.subtract(shape[::-1], 1)).astype(int).tolist()
    x1, y1 = np.clip(np.ceil(box_xyxy[2:]), [x0 + 1, y0 + 1], shape[::-1]).astype(int).tolist()
    return x0, y0, x1, y1
