"""Plan view of the point cloud: its density and connected dense regions (paper B, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray


@dataclass(frozen=True)
class PlanViewParameters:
    """Settings of the plan view.

    Attributes:
        cell_m: side of a cell.
        farthest_m: length ahead; the width is the picture's at this distance.
        lowest_m, highest_m: range of heights, without ground and ceilings; higher than people, so that taller objects
            are recognised.
        least_area_m2: least surface facing the camera in a dense cell.
        disparity_noise_px: standard deviation of a disparity; it spreads distant points over several cells.
        step: factor between the density levels by which regions too large for a person are split.
        levels: number of levels.
        least_contrast: least ratio of a split piece's density to that of its surroundings: people who touch each other
            or a wall have it, pieces of a wall do not.
    """

    cell_m: float = 0.08
    farthest_m: float = 10.0
    lowest_m: float = 0.2
    highest_m: float = 2.2
    least_area_m2: float = 0.02
    disparity_noise_px: float = 0.4
    step: float = 1.6
    levels: int = 5
    least_contrast: float = 1.6


@dataclass(frozen=True)
class PlanView:
    """Surface in the cells of a grid on the ground.

    Attributes:
        cell_of_pixel: (H', W') int32, index of the cell that a pixel's point falls into, -1 for none.
        area_m2: (X, Y) surface facing the camera in each cell: a pixel at distance z shows (z / f)², so a person's
            surface is the same at any distance.
        least_area_m2: (X, 1) least surface of a dense cell at each distance.
        cell_m: side of a cell; cell (i, j) covers x in [i, i + 1) and y in [j, j + 1) - Y / 2 of it.
    """

    cell_of_pixel: NDArray[np.int32]
    area_m2: NDArray[np.float32]
    least_area_m2: NDArray[np.float32]
    cell_m: float


def plan_view(
    points_m: NDArray[np.float32],
    focal_px: float,
    focal_baseline_m: float,
    parameters: PlanViewParameters,
) -> PlanView:
    """Return the plan view of a point cloud (H', W', 3) in the robot's frame.

    Args:
        focal_px: focal length in pixels of the point cloud's picture.
        focal_baseline_m: ``f b`` of the full picture: a disparity error of 1 px is a depth error of ``z² / (f b)``.
    """
    p = parameters
    rows = int(np.ceil(p.farthest_m / p.cell_m))
    aside_m = p.farthest_m * 0.5 * points_m.shape[1] / focal_px
    columns = 2 * int(np.ceil(aside_m / p.cell_m))
    cells, area = _fill(points_m, focal_px, rows, columns, p.cell_m, p.lowest_m, p.highest_m)
    ahead_m = (np.arange(rows, dtype=np.float32)[:, None] + 0.5) * p.cell_m
    spread_m = p.disparity_noise_px * ahead_m**2 / focal_baseline_m
    return PlanView(cells, area, (p.least_area_m2 / (1.0 + 2.0 * spread_m / p.cell_m)).astype(np.float32), p.cell_m)


@njit(cache=True)
def _fill(points_m, focal_px, rows, columns, cell_m, lowest_m, highest_m):  # type: ignore[no-untyped-def]
    cells = np.full(points_m.shape[:2], -1, np.int32)
    area = np.zeros((rows, columns), np.float32)
    for i in range(points_m.shape[0]):
        for j in range(points_m.shape[1]):
            x, y, z = points_m[i, j]
            # NaN fails this test.
            if not (lowest_m <= z <= highest_m and x >= 0.0):
                continue
            row, column = int(x / cell_m), int(np.floor(y / cell_m)) + columns // 2
            if row < rows and 0 <= column < columns:
                cells[i, j] = row * columns + column
                area[row, column] += (x / focal_px) ** 2
    return cells, area


def dense_regions(
    plan: PlanView, person_m: tuple[float, float], group_m: tuple[float, float], parameters: PlanViewParameters
) -> NDArray[np.int32]:
    """Return the region number of each cell (X, Y), 0 for none: dense regions with the size of a person or small group.

    Dense cells that touch form a region. A region larger than a person may be several people or a person at a wall: it
    is split by raising the density threshold, level by level, until its pieces are small enough or nothing is left.
    Each piece is then dilated by one cell. A region that cannot be split is kept if it is no larger than a group.

    Args:
        person_m, group_m: largest size (across, along) the line of sight.
    """
    relative = plan.area_m2 / plan.least_area_m2
    # Closes holes and gaps of one cell.
    closed = cv2.morphologyEx(relative, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    regions = np.zeros(relative.shape, np.int32)

    def split(piece: NDArray[np.bool_], window: tuple[slice, slice], level: int) -> bool:
        """Number the regions in a piece and return whether there were any."""
        extent_m = _extent_m(piece, window, plan)
        if not _fits(extent_m, person_m):
            denser = piece & (closed[window] >= parameters.step ** (level + 1)) if level < parameters.levels else None
            parts = [] if denser is None else [split(*part, level + 1) for part in _pieces(denser, window)]
            if any(parts):
                return True
            if not _fits(extent_m, group_m):
                return False
        if level > 0:
            ring = (cv2.dilate(piece.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0) & ~piece
            touching = closed[window][ring & (closed[window] >= 1.0)]
            if len(touching) and closed[window][piece].mean() < parameters.least_contrast * touching.mean():
                return False
            piece = piece | ring
        regions[window][piece & (regions[window] == 0)] = regions.max() + 1
        return True

    everywhere = (slice(0, relative.shape[0]), slice(0, relative.shape[1]))
    for part in _pieces(closed >= 1.0, everywhere):
        split(*part, 0)
    return regions


def _fits(extent_m: tuple[float, float], largest_m: tuple[float, float]) -> bool:
    return extent_m[0] <= largest_m[0] and extent_m[1] <= largest_m[1]


def _pieces(
    mask: NDArray[np.bool_], window: tuple[slice, slice]
) -> list[tuple[NDArray[np.bool_], tuple[slice, slice]]]:
    """Return connected pieces of at least two cells, each with its window in the grid, one cell wider on each side."""
    found, labels, boxes, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    pieces = []
    for label in range(1, found):
        x, y, width, height, cells = boxes[label]
        if cells < 2:
            continue
        rows = slice(max(y - 1, 0), min(y + height + 1, mask.shape[0]))
        columns = slice(max(x - 1, 0), min(x + width + 1, mask.shape[1]))
        in_grid = tuple(
            slice(int(inner.start + outer.start), int(inner.stop + outer.start))
            for inner, outer in zip((rows, columns), window, strict=True)
        )
        pieces.append((labels[rows, columns] == label, (in_grid[0], in_grid[1])))
    return pieces


def _extent_m(piece: NDArray[np.bool_], window: tuple[slice, slice], plan: PlanView) -> tuple[float, float]:
    """Return a piece's size across and along the line of sight to its middle, there without the errors of distance."""
    rows, columns = np.nonzero(piece)
    x = plan.cell_m * (rows + window[0].start + 0.5)
    y = plan.cell_m * (columns + window[1].start + 0.5 - plan.area_m2.shape[1] / 2)
    direction = np.array([x.mean(), y.mean()])
    cosine, sine = direction / max(float(np.hypot(*direction)), 1e-9)
    across, along = cosine * y - sine * x, cosine * x + sine * y
    spread_m = plan.cell_m * (plan.least_area_m2[0, 0] / plan.least_area_m2[int(direction[0] / plan.cell_m), 0] - 1.0)
    return float(np.ptp(across)) + plan.cell_m, float(np.ptp(along)) + plan.cell_m - 2.0 * float(spread_m)
