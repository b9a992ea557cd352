"""The canvas that the ground is painted on, and the colours of a town."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

Rgb = tuple[int, int, int]

PAINTS: dict[str, tuple[Rgb, float]] = {
    "white": ((232, 232, 228), 0.20),
    "black": ((26, 26, 29), 0.16),
    "grey": ((92, 95, 99), 0.14),
    "silver": ((164, 168, 172), 0.11),
    "blue": ((28, 62, 150), 0.11),
    "red": ((176, 24, 26), 0.10),
    "green": ((24, 92, 58), 0.04),
    "yellow": ((222, 176, 32), 0.04),
    "orange": ((208, 92, 24), 0.03),
    "brown": ((98, 64, 42), 0.03),
    "sky": ((92, 158, 200), 0.04),
}
"""Car paints and their shares: roughly those of new cars in Europe, with more colours than today."""

WALLS: tuple[Rgb, ...] = (
    (214, 204, 186),
    (196, 180, 152),
    (226, 222, 212),
    (178, 146, 118),
    (160, 98, 76),
    (188, 190, 188),
    (206, 184, 136),
)
ROOFS: tuple[Rgb, ...] = (
    (146, 88, 72),
    (128, 74, 60),
    (104, 72, 62),
    (84, 84, 88),
    (64, 66, 72),
    (128, 108, 92),
    (158, 104, 80),
    (98, 94, 90),
)
FLAT_ROOFS: tuple[Rgb, ...] = ((128, 128, 124), (104, 106, 106), (150, 146, 136), (88, 90, 94), (166, 164, 158))
LAWNS: tuple[Rgb, ...] = ((88, 106, 64), (98, 114, 68), (80, 96, 60), (110, 116, 74), (94, 104, 70))
YARDS: tuple[Rgb, ...] = ((150, 140, 124), (132, 126, 116), (164, 152, 130), (118, 104, 84))
CROPS: tuple[Rgb, ...] = ((122, 104, 78), (134, 128, 72), (84, 104, 50), (146, 136, 92), (104, 116, 62))
BEDS: tuple[Rgb, ...] = ((96, 78, 58), (72, 88, 48), (120, 96, 88), (142, 84, 92), (150, 132, 70), (84, 66, 50))
HEDGES: tuple[Rgb, ...] = ((58, 78, 42), (66, 84, 46), (48, 68, 38), (128, 118, 100), (104, 88, 70))
PATHS: tuple[Rgb, ...] = ((158, 150, 134), (142, 132, 114), (128, 126, 122), (150, 128, 112), (168, 162, 150))
MEADOW: Rgb = (94, 108, 62)
PAVEMENT: Rgb = (156, 152, 144)
KERB: Rgb = (150, 148, 142)
ASPHALT: tuple[Rgb, ...] = ((84, 85, 88), (92, 92, 93), (76, 78, 82))
MARKING: Rgb = (214, 214, 208)


def draw_paint(rng: np.random.Generator) -> Rgb:
    """Draw a car paint by its share."""
    shares = np.array([share for _, share in PAINTS.values()])
    paints = [rgb for rgb, _ in PAINTS.values()]
    return paints[int(rng.choice(len(paints), p=shares / shares.sum()))]


def pick(colours: tuple[Rgb, ...], rng: np.random.Generator, spread: float = 8.0) -> Rgb:
    """Draw one of ``colours`` and vary it a little, mostly in lightness."""
    rgb = np.array(colours[int(rng.integers(len(colours)))], dtype=float)
    rgb += rng.normal(0.0, spread) + rng.normal(0.0, 0.3 * spread, 3)
    r, g, b = np.clip(rgb, 8, 247).astype(int).tolist()
    return r, g, b


_SHIFT = 4
"""OpenCV's fractional bits of pixel coordinates."""
_GRAIN_TILE_PX = 512

Colour = int | tuple[int, int, int]


class Canvas:
    """Draws anti-aliased shapes given in world metres.

    Attributes:
        picture: (size, size, 3) uint8, or (size, size, 1) for maps of classes, whose edges are not blended; row 0 is
            at +y, column 0 at -x.
    """

    def __init__(self, picture: NDArray[np.uint8], extent_m: float) -> None:
        self.picture = picture
        self.extent_m = extent_m
        self._px_per_m = len(picture) / extent_m
        self._line_type = cv2.LINE_AA if picture.shape[2] == 3 else cv2.LINE_8

    def polygon(self, corners_m: NDArray[np.float64], colour: Colour) -> None:
        """Fill a convex polygon (n, 2)."""
        cv2.fillConvexPoly(self.picture, self._fixed_point(corners_m), _scalar(colour), self._line_type, _SHIFT)

    def area(self, area: shapely.Geometry, colour: Colour) -> None:
        """Fill polygons, except their holes."""
        rings = [self._fixed_point(shapely.get_coordinates(ring)) for ring in rings_of(area)]
        cv2.fillPoly(self.picture, rings, _scalar(colour), self._line_type, _SHIFT)

    def outline(self, area: shapely.Geometry, width_m: float, colour: Colour) -> None:
        """Draw the edges of polygons, holes included."""
        for ring in rings_of(area):
            self.line(shapely.get_coordinates(ring), width_m, colour)

    def line(self, points_m: NDArray[np.float64], width_m: float, colour: Colour) -> None:
        """Draw a polyline (n, 2), at least a pixel wide, with round ends."""
        width_px = max(1, round(width_m * self._px_per_m))
        points = [self._fixed_point(points_m)]
        cv2.polylines(self.picture, points, False, _scalar(colour), width_px, self._line_type, _SHIFT)

    def bar(self, start_m: NDArray[np.float64], end_m: NDArray[np.float64], width_m: float, colour: Colour) -> None:
        """Draw a straight bar with square ends."""
        along = end_m - start_m
        side = 0.5 * width_m * np.array([-along[1], along[0]]) / np.linalg.norm(along)
        self.polygon(np.array([start_m - side, end_m - side, end_m + side, start_m + side]), colour)

    def disc(self, centre_m: NDArray[np.float64], radius_m: float, colour: Colour) -> None:
        """Fill a circle."""
        self.discs(np.asarray(centre_m)[None], np.array([radius_m]), [colour])

    def discs(self, centres_m: NDArray[np.float64], radii_m: NDArray[np.float64], colours: Sequence[Colour]) -> None:
        """Fill circles: centres (n, 2), radii (n,) and n colours."""
        centres = self._fixed_point(centres_m).tolist()
        radii = np.round(radii_m * self._px_per_m * (1 << _SHIFT)).astype(int).tolist()
        for centre, radius, colour in zip(centres, radii, colours, strict=True):
            cv2.circle(self.picture, centre, radius, _scalar(colour), -1, self._line_type, _SHIFT)

    def grain(self, rng: np.random.Generator, deviation: float) -> None:
        """Add noise of texel size to the picture; one tile of it is repeated, turned and mirrored."""
        noise = rng.normal(0.0, deviation, (_GRAIN_TILE_PX, _GRAIN_TILE_PX, 1)).round()
        brighter, darker = (np.maximum(sign * noise, 0).astype(np.uint8) + np.zeros(3, np.uint8) for sign in (1, -1))
        turned = [(_turned(brighter, *turn), _turned(darker, *turn)) for turn in _TURNS]
        size, is_mirrored, quarters = len(self.picture), False, 0
        for top in range(0, size, _GRAIN_TILE_PX):
            for left in range(0, size, _GRAIN_TILE_PX):
                part = self.picture[top : top + _GRAIN_TILE_PX, left : left + _GRAIN_TILE_PX]
                rows, columns = part.shape[:2]
                brighter, darker = turned[_TURNS.index((is_mirrored, quarters))]
                cv2.subtract(cv2.add(part, brighter[:rows, :columns]), darker[:rows, :columns], dst=part)
                if (top + left) % 1024:
                    quarters = (quarters + 1) % 4
                else:
                    is_mirrored, quarters = not is_mirrored, -quarters % 4

    def window(self, corners_m: NDArray[np.float64]) -> tuple[slice, slice, NDArray[np.int32]]:
        """Return the rows and columns that a polygon (n, 2) reaches over, and its corners in them, whole pixels."""
        pixels = (self._fixed_point(corners_m) + (1 << (_SHIFT - 1))) >> _SHIFT
        low = np.clip(pixels.min(axis=0), 0, len(self.picture))
        high = np.clip(pixels.max(axis=0) + 1, 0, len(self.picture))
        return slice(low[1], high[1]), slice(low[0], high[0]), pixels - low

    def _fixed_point(self, points_m: NDArray[np.float64]) -> NDArray[np.int32]:
        half_m = 0.5 * self.extent_m
        x = (points_m[:, 0] + half_m) * self._px_per_m - 0.5
        y = (half_m - points_m[:, 1]) * self._px_per_m - 0.5
        fixed = np.empty((len(x), 2))
        fixed[:, 0], fixed[:, 1] = x, y
        return np.rint(fixed * (1 << _SHIFT)).astype(np.int32)


_TURNS = [(is_mirrored, quarters) for is_mirrored in (False, True) for quarters in range(4)]


def _turned(tile: NDArray[np.uint8], is_mirrored: bool, quarters: int) -> NDArray[np.uint8]:
    return np.ascontiguousarray(np.rot90(tile[::-1] if is_mirrored else tile, quarters))


def rectangle(
    centre_m: NDArray[np.float64] | tuple[float, float], size_m: tuple[float, float], yaw_rad: float
) -> NDArray[np.float64]:
    """Return the corners (4, 2) of a rectangle, counter-clockwise from (-x, -y) in its own frame, metres."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    half = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size_m
    return np.asarray(centre_m) + half @ np.array([[c, s], [-s, c]])


def rings_of(area: shapely.Geometry) -> list[shapely.LinearRing]:
    """Return the outlines and holes of one or more polygons."""
    polygons = [part for part in shapely.get_parts(area) if isinstance(part, shapely.Polygon)]
    return [ring for polygon in polygons for ring in (polygon.exterior, *polygon.interiors)]


def smooth_noise(rng: np.random.Generator, size_px: int, deviation_by_cells: dict[int, float]) -> NDArray[np.float32]:
    """Return noise (size, size) of several scales.

    Args:
        deviation_by_cells: number of cells along a side -> standard deviation of the noise at that scale.
    """
    total, scaled = np.zeros((size_px, size_px), np.float32), np.empty((size_px, size_px), np.float32)
    for cells, deviation in deviation_by_cells.items():
        noise = deviation * rng.standard_normal((cells, cells), dtype=np.float32)
        total += cv2.resize(noise, (size_px, size_px), dst=scaled, interpolation=cv2.INTER_CUBIC)
    return total


def _scalar(colour: Colour) -> tuple[int, ...]:
    return (colour,) if isinstance(colour, int) else colour
