"""A square picture of the ground that is drawn on in metres."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_SHIFT = 4
"""OpenCV's fixed-point bits below a pixel."""


class Canvas:
    """Draws anti-aliased shapes given in world metres.

    Attributes:
        rgb: (size, size, channels) uint8; row 0 is +y, column 0 is -x.
    """

    def __init__(self, extent_m: float, size_px: int, channels: int = 3) -> None:
        self.rgb = np.zeros((size_px, size_px, channels), dtype=np.uint8)
        self._half_m = 0.5 * extent_m
        self._px_per_m = size_px / extent_m
        self._line_type = cv2.LINE_AA if channels == 3 else cv2.LINE_8

    def rectangle(
        self, centre_m: tuple[float, float], size_m: tuple[float, float], yaw_rad: float
    ) -> NDArray[np.float64]:
        """Return the corners (4, 2) of a rectangle, metres."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        half = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size_m
        return np.asarray(centre_m) + half @ np.array([[c, s], [-s, c]])

    def polygon(self, corners_m: NDArray[np.float64], colour: int | tuple[int, int, int]) -> None:
        """Fill a convex polygon (n, 2)."""
        cv2.fillConvexPoly(self.rgb, self._fixed_point(corners_m), _scalar(colour), self._line_type, _SHIFT)

    def line(self, points_m: NDArray[np.float64], width_m: float, colour: int | tuple[int, int, int]) -> None:
        """Draw a polyline (n, 2), at least a pixel wide."""
        width_px = max(1, round(width_m * self._px_per_m))
        cv2.polylines(
            self.rgb, [self._fixed_point(points_m)], False, _scalar(colour), width_px, self._line_type, _SHIFT
        )

    def disc(self, centre_m: NDArray[np.float64], radius_m: float, colour: tuple[int, int, int]) -> None:
        """Fill a circle."""
        centre = self._fixed_point(np.asarray(centre_m)[None])[0]
        radius = round(radius_m * self._px_per_m * (1 << _SHIFT))
        cv2.circle(self.rgb, centre.tolist(), radius, _scalar(colour), -1, self._line_type, _SHIFT)

    def fill_with_noise(
        self, colour: tuple[int, int, int], rng: np.random.Generator, deviation_by_cells: dict[int, float]
    ) -> None:
        """Fill with a colour whose lightness and hue vary at several scales.

        Args:
            deviation_by_cells: number of cells along a side -> standard deviation of the variation at that scale.
        """
        size = self.rgb.shape[0]
        # Hue varies slowly; one picture of it at low resolution is enough.
        hue = cv2.resize(rng.normal(0, 3.5, (96, 96, 3)).astype(np.float32), (size, size))
        lightness = np.zeros((size, size), dtype=np.float32)
        for cells, deviation in deviation_by_cells.items():
            noise = (deviation * rng.standard_normal((cells, cells), dtype=np.float32)).astype(np.float32)
            lightness += cv2.resize(noise, (size, size), interpolation=cv2.INTER_LINEAR)
        hue += lightness[..., None]
        hue += np.array(colour, dtype=np.float32)
        np.clip(hue, 0, 255, out=hue)
        self.rgb[:] = hue

    def grain(self, rng: np.random.Generator, deviation: float) -> None:
        """Add noise of texel size to everything drawn so far; a tile of it is repeated."""
        size = self.rgb.shape[0]
        tile = rng.normal(0.0, deviation, (1024, 1024)).round().astype(np.int8)
        repeats = -(-size // 1024)
        noise = np.tile(tile, (repeats, repeats))[:size, :size]
        brighter = cv2.merge([np.maximum(noise, 0).astype(np.uint8)] * 3)
        darker = cv2.merge([np.maximum(-noise, 0).astype(np.uint8)] * 3)
        self.rgb = cv2.subtract(cv2.add(self.rgb, brighter), darker)

    def _fixed_point(self, points_m: NDArray[np.float64]) -> NDArray[np.int32]:
        x = (points_m[:, 0] + self._half_m) * self._px_per_m - 0.5
        y = (self._half_m - points_m[:, 1]) * self._px_per_m - 0.5
        return np.round(np.column_stack([x, y]) * (1 << _SHIFT)).astype(np.int32)


def _scalar(colour: int | tuple[int, int, int]) -> tuple[int, ...]:
    return (colour,) if isinstance(colour, int) else colour
