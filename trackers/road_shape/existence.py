"""Existence probability of a car: classes of pixels by colour, corrected by the road's shape (paper A, section 4.1)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.road_shape.road_model import RoadCurve, evaluate_spline


@dataclass(frozen=True)
class ClassStatistics:
    """Colours of the two classes of paper A.3 that are defined by colour, in L lights of both together.

    Attributes:
        mean_rgb, variance_rgb: (L, 3), sRGB 0-255.
        of_road: (L,) True for road's, False for other's.
    """

    mean_rgb: NDArray[np.float64]
    variance_rgb: NDArray[np.float64]
    of_road: NDArray[np.bool_]


def load_class_statistics(model: str) -> ClassStatistics:
    """Read the statistics of a shipped model by its name, or of a file by its path ending in ``.json``.

    Raises:
        ValueError: if there is no such model.
    """
    bundled = resources.files(__package__).joinpath(f"{model}.json")
    file = Path(model) if model.endswith(".json") else bundled
    if not file.is_file():
        raise ValueError(f"class_model: expected a model's name or the path of a .json file, got {model!r}")
    classes = json.loads(file.read_text())["classes"]
    road, other = classes["road"], classes["other"]
    mean_rgb, variance_rgb = (
        np.array([light[key] for light in (*road, *other)]) for key in ("mean_rgb", "variance_rgb")
    )
    return ClassStatistics(mean_rgb, variance_rgb, np.arange(len(mean_rgb)) < len(road))


ROAD_EXISTENCE, OTHER_EXISTENCE, BUILDING_EXISTENCE = 1.0, 0.8, 0.1
ROAD, OTHER, BUILDING = 0, 1, 2
_UNKNOWN = 255
_MOST_SAMPLED = 256


class PixelClassifier:
    """The paper's rule for the class of a pixel. Each colour is judged once, as there are far fewer than pixels."""

    def __init__(
        self, mean_rgb: NDArray[np.float64], variance_rgb: NDArray[np.float64], of_road: NDArray[np.bool_]
    ) -> None:
        """Take the statistics of L lights: means and variances (L, 3), 0-255, and whether they are road's (L,)."""
        # Each band's share of each distance for each of its 256 values.
        self._shares = (np.arange(256.0) - mean_rgb[:, :, None]) ** 2 / (3.0 * variance_rgb[:, :, None])
        self._of_road = of_road
        self._known = np.full(1 << 24, _UNKNOWN, np.uint8)

    def classify(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the class of each pixel (H, W) of a picture (H, W, 3): 0 road, 1 other, 2 building.

        ``d_l² = 1/3 Σ_bands (x - μ_l)² / s_l`` for the statistics of each light l of a class; a pixel is within a class
        if ``d_l² < 1`` in one of its lights; road if within road's alone, other if within other's alone, building if
        within neither or both (equations 4.5-4.9).

        Reading: the distance is standardised per band and its mean over the bands is compared with one, which is
        ``rd² < rs`` if all bands have the same variance. Ours: each light has statistics of its own; the paper has one
        light, see ``benchmarks/papers/ground_colours.py``.
        """
        return _classify(image_rgb, self._shares, self._of_road, self._known)


@njit(cache=True)
def _classify(image_rgb, shares, of_road, known):  # type: ignore[no-untyped-def]
    rows, columns, _ = image_rgb.shape
    classes = np.empty((rows, columns), np.uint8)
    for i in range(rows):
        for j in range(columns):
            r, g, b = np.uint32(image_rgb[i, j, 0]), np.uint32(image_rgb[i, j, 1]), np.uint32(image_rgb[i, j, 2])
            colour = r << 16 | g << 8 | b
            if known[colour] == _UNKNOWN:
                known[colour] = _class_of(shares[:, 0, r], shares[:, 1, g], shares[:, 2, b], of_road)
            classes[i, j] = known[colour]
    return classes


@njit(cache=True)
def _class_of(red_shares, green_shares, blue_shares, of_road):  # type: ignore[no-untyped-def]
    is_road, is_other = False, False
    for light in range(len(of_road)):
        if red_shares[light] + green_shares[light] + blue_shares[light] < 1.0:
            is_road = is_road or of_road[light]
            is_other = is_other or not of_road[light]
    return BUILDING if is_road == is_other else ROAD if is_road else OTHER


@njit(cache=True)
def mean_existence(
    classes: NDArray[np.uint8],
    corners_px: NDArray[np.int64],
    width: int,
    height: int,
    axis: int,
    road_line_px: NDArray[np.float64],
    line_start: int,
    half_road_px: NDArray[np.float64],
    pavement_px: float,
) -> NDArray[np.float64]:
    """Return a car's mean existence probability (N,) over the pixels of each rectangle (equation 4.9, section 4.3).

    A pixel outside the picture has the class of the nearest pixel inside. Within half the road's width of its line the
    class is road, and building up to ``pavement_px`` farther too. Road has probability 1, other 0.8, building 0.1. In a
    large rectangle only every k-th row and column is used.

    Args:
        classes: (H, W).
        corners_px: (N, 2) top left corner (column, row) of each rectangle, width x height, in the picture or not.
        axis: 0 if the line gives y for each column, 1 if x for each row.
        road_line_px: (M,) position of the road's line across the axis at pixels line_start, line_start + 1, ... along
            it; empty if no road is known.
        half_road_px: (M,) half the road's width, measured across the axis.
    """
    rows, columns = classes.shape
    existence = np.array([ROAD_EXISTENCE, OTHER_EXISTENCE, BUILDING_EXISTENCE])
    means = np.empty(len(corners_px))
    step = 1 + max(width, height) // _MOST_SAMPLED
    for n in range(len(corners_px)):
        left, top = corners_px[n]
        total, count = 0.0, 0
        for i in range(top, top + height, step):
            row = min(max(i, 0), rows - 1)
            for j in range(left, left + width, step):
                kind = classes[row, min(max(j, 0), columns - 1)]
                k = (j if axis == 0 else i) - line_start
                if kind != ROAD and 0 <= k < road_line_px.size:
                    beside = abs((i if axis == 0 else j) + 0.5 - road_line_px[k])
                    if beside < half_road_px[k] or (kind == BUILDING and beside < half_road_px[k] + pavement_px):
                        kind = ROAD
                total += existence[kind]
                count += 1
        means[n] = total / count
    return means


_PAVEMENT_SHARE = 0.5
"""Reading: building pixels beside the road count as road (pavement, cars) up to this share of its half width."""

_FARTHEST_PX = 2000.0


class ExistenceMap:
    """Existence probability of a car on the pixels of one picture and around it."""

    def __init__(
        self,
        image_rgb: NDArray[np.uint8],
        classifier: PixelClassifier,
        road: RoadCurve | None,
        centre_px: NDArray[np.float64],
    ) -> None:
        """Classify a picture (H, W, 3) with its centre (2,); a known road is in pixels from the centre."""
        self._classes = classifier.classify(image_rgb)
        self._road = road
        self._centre_px = centre_px

    def mean_over(self, centres_px: NDArray[np.float64], size_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean probability (N,) over rectangles of a size (2,) around positions (N, 2), at least 0.1."""
        width, height = (max(int(side), 1) for side in np.rint(size_px))
        near = np.clip(np.nan_to_num(centres_px), -_FARTHEST_PX, _FARTHEST_PX)
        corners = np.floor(near - 0.5 * np.array([width, height]) + 0.5).astype(np.int64)
        axis = 0 if self._road is None else self._road.axis
        start, line, half = self._road_line(corners, axis, max(width, height))
        pavement_px = 0.0 if self._road is None else _PAVEMENT_SHARE * self._road.half_width_px
        # Particles in the same pixel share a rectangle.
        distinct, which = np.unique(corners, axis=0, return_inverse=True)
        means = mean_existence(self._classes, distinct, width, height, axis, line, start, half, pavement_px)
        return means[which]

    def _road_line(
        self, corners: NDArray[np.int64], axis: int, extent: int
    ) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
        """Return the first pixel along the axis, and the road's position and half width across it from there on."""
        if self._road is None:
            return 0, np.empty(0), np.empty(0)
        start = int(corners[:, axis].min())
        along = np.arange(start, int(corners[:, axis].max()) + extent) + 0.5 - self._centre_px[axis]
        values, slopes = evaluate_spline(self._road.knots, self._road.pieces, along)
        return start, values + self._centre_px[1 - axis], self._road.half_width_px * np.hypot(1.0, slopes)
