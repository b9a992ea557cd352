"""What a camera saw before and where estimates were, carried along with its motion, for drawing around its picture.

The motion is measured from picture to picture: the homography of ``picture_motion``, by corners and RANSAC. It is that
of a flat scene, or of a camera that turns in place; what stands out of the scene shifts. There are no metres in it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Instant
from trackers.kernels.ground_camera import apply_homography
from trackers.kernels.picture_motion import picture_motion
from trackers.types import Estimate

_LONGEST_PX, _NARROWEST_PX = 1920, 960
"""Longest side of a view, and least width of one that is shrunk: the words below need it."""
_MEASURED_PX = 480
"""Longest side of the pictures that a motion is measured on."""
_MOST_LEVELS, _BETTER, _OLDEST = 40, 0.95, 30
"""Limit of a pixel's difference, in levels; ratio of mean differences with and without a motion, below which there is
one; and pictures at rest after which a motion is measured from a newer one."""
_PATH_S = 4.0
"""Time over which a path is drawn."""
_CENTRES = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
_MOVED = 0.1
"""Motion, in widths of the picture, after which the mosaic is made anew with the latest picture."""


class CameraMotion:
    """Measures how the picture moves; a camera at rest is one whose motion explains the picture no better than none.

    What it measures from is the latest picture in which it moved, so that slow motion adds up until it is seen.
    """

    def __init__(self) -> None:
        self._before: NDArray[np.uint8] | None = None
        self._at_rest = 0

    def until(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Return the homography (3, 3) from pixels of the picture before to those of this one (H, W, 3).

        It is the identity for the first picture, at rest, and where ``picture_motion`` finds none.
        """
        height, width = image_rgb.shape[:2]
        shrunk = min(1.0, _MEASURED_PX / max(height, width))
        size = max(round(width * shrunk), 1), max(round(height * shrunk), 1)
        small = cv2.resize(image_rgb, size, interpolation=cv2.INTER_AREA)
        now = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), np.uint8)
        motion = np.eye(3) if self._before is None else picture_motion(self._before, now)
        moves = self._before is not None and _explains(motion, self._before, now)
        self._at_rest = 0 if moves else self._at_rest + 1
        if moves or self._before is None or self._at_rest == _OLDEST:
            self._before, self._at_rest = now, 0
        if not moves:
            return np.eye(3)
        scale = np.array([size[0] / width, size[1] / height, 1.0])
        return motion * scale / scale[:, None]


def _explains(motion: NDArray[np.float64], before: NDArray[np.uint8], now: NDArray[np.uint8]) -> bool:
    """Return whether a picture (H, W) is more like the one before if that is moved than if it is not."""
    H = _CENTRES @ motion @ np.linalg.inv(_CENTRES)
    size = (now.shape[1], now.shape[0])
    moved, seen = (cv2.warpPerspective(each, H, size) for each in (before, np.full_like(before, 255)))
    inside = seen == 255
    if not inside.any():
        return False
    # What moves by itself counts no more than this.
    away, still = (np.minimum(cv2.absdiff(each, now)[inside], _MOST_LEVELS).mean() for each in (moved, before))
    return bool(away < _BETTER * still)


class Paths:
    """Where the estimates of the last seconds are in the present picture, by the camera's motion since."""

    def __init__(self, rate_hz: float) -> None:
        self._most = max(round(_PATH_S * rate_hz), 2)
        self._paths: dict[str, NDArray[np.float64]] = {}

    def extended(
        self, motion: NDArray[np.float64], estimates: Iterable[tuple[str, Estimate]]
    ) -> Mapping[str, NDArray[np.float64]]:
        """Return the paths (K, 2) in the present picture, oldest place first, by identity; NaN without an answer.

        Args:
            motion: (3, 3) from the picture before to this one.
            estimates: of this picture with their identities.
        """
        answered = {name: each.position_px for name, each in estimates}
        longer = {}
        for name in self._paths.keys() | answered.keys():
            carried = apply_homography(motion, self._paths.get(name, np.empty((0, 2))))
            path = np.vstack([carried, answered.get(name, np.full(2, np.nan))])[-self._most :]
            if np.isfinite(path).any():
                longer[name] = path
        self._paths = longer
        return longer


class Mosaic:
    """A view around the picture, with earlier pictures where they were seen.

    Attributes:
        zoom: pixels of the view over those of the picture, at most 1.
    """

    def __init__(self, image_rgb: NDArray[np.uint8], scale: float) -> None:
        """``image_rgb``: (H, W, 3), one of the pictures. ``scale``: size of the view over that of the picture."""
        height, width = image_rgb.shape[:2]
        self.zoom = min(1.0, _LONGEST_PX / (scale * max(height, width)))
        self._inner = round(width * self.zoom), round(height * self.zoom)
        wide, high = (round(scale * side) for side in self._inner)
        if self.zoom < 1.0:
            wide = max(wide, _NARROWEST_PX)
        column, row = (wide - self._inner[0]) // 2, (high - self._inner[1]) // 2
        self._middle = slice(row, row + self._inner[1]), slice(column, column + self._inner[0])
        self._to_view = np.array([[self.zoom, 0.0, column], [0.0, self.zoom, row], [0.0, 0.0, 1.0]])
        self._size = wide, high
        self._kept: NDArray[np.uint8] | None = None
        self._motion = np.eye(3)

    def with_picture(
        self, image_rgb: NDArray[np.uint8], motion: NDArray[np.float64], *, is_wanted: bool = True
    ) -> NDArray[np.uint8] | None:
        """Return the view (H, W, 3) with the next picture in its middle; it may be None where it is not wanted.

        ``motion``: (3, 3) from the picture before.
        """
        self._motion = motion @ self._motion
        has_moved = self._has_moved(image_rgb)
        view = self._view(image_rgb) if is_wanted or has_moved else None
        if has_moved:
            self._kept, self._motion = view, np.eye(3)
        return view

    def _view(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        if self._kept is None or not np.isfinite(self._motion_px(image_rgb)):
            view = np.full((*self._size[::-1], 3), marks.GROUND, np.uint8)
        else:
            # OpenCV counts pixel centres as whole numbers.
            to_centres = _CENTRES @ self._to_view
            H = to_centres @ self._motion @ np.linalg.inv(to_centres)
            view = cv2.warpPerspective(self._kept, H, self._size, borderValue=marks.GROUND).astype(np.uint8)
        view[self._middle] = cv2.resize(image_rgb, self._inner, interpolation=cv2.INTER_AREA)
        return view

    def _has_moved(self, image_rgb: NDArray[np.uint8]) -> bool:
        """Return whether the latest view is to be kept: all are interpolated once from the kept one, so that they do
        not blur while the camera hardly moves.
        """
        return self._kept is None or not self._motion_px(image_rgb) < _MOVED * image_rgb.shape[1]

    def _motion_px(self, image_rgb: NDArray[np.uint8]) -> float:
        """Return how far the picture's farthest corner has moved since the kept view; NaN if behind the camera."""
        height, width = image_rgb.shape[:2]
        corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
        return float(np.linalg.norm(apply_homography(self._motion, corners) - corners, axis=1).max())


def surrounded(instants: Iterable[Instant], rate_hz: float, scale: float | None = None) -> Iterator[Instant]:
    """Yield consecutive instants with the paths of their estimates.

    Args:
        rate_hz: instants a second.
        scale: of the larger view, a ``Mosaic`` of what was seen before; None leaves the one that they have.
    """
    for (instant,) in surrounded_all(([each] for each in instants), rate_hz, scale):
        yield instant


def surrounded_all(
    instants: Iterable[Sequence[Instant]],
    rate_hz: float,
    scale: float | None = None,
    wanted: Container[int] | None = None,
) -> Iterator[list[Instant]]:
    """Yield for each of the ``wanted`` frames, None = all, the instants of all trackers, see ``surrounded``.

    Args:
        instants: of consecutive frames, those of all trackers on one picture.
    """
    motion, paths, mosaic = CameraMotion(), defaultdict[int, Paths](lambda: Paths(rate_hz)), None
    for of_frame in instants:
        frame = of_frame[0].frame
        image_rgb = frame.observation.image_rgb
        moved = motion.until(image_rgb)
        shown = [replace(one, paths=paths[k].extended(moved, one.estimates)) for k, one in enumerate(of_frame)]
        is_wanted = wanted is None or frame.truth.frame in wanted
        if scale is not None:
            mosaic = mosaic or Mosaic(image_rgb, scale)
            view = mosaic.with_picture(image_rgb, moved, is_wanted=is_wanted)
            if view is not None:
                shown = [replace(one, larger_view_rgb=view, zoom=mosaic.zoom) for one in shown]
        if is_wanted:
            yield shown
