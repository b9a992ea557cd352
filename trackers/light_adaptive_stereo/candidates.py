"""Candidates for people: dense regions of the point cloud from above, as large as a person (paper B, section 3.1)."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.kernels.boxes import box_size
from trackers.light_adaptive_stereo.matching import baseline_m
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.types import CameraModel


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
    points_m: NDArray[np.float32], focal_px: float, focal_baseline_m: float, parameters: PlanViewParameters
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


_BORDER_PX = 3
"""A region this near to the border of the depth picture may extend beyond it."""
_HEAD_BIN_M = _HEIGHT_BIN_M = 0.05
_WIDE_AGAIN, _LEAST_HEAD_BINS, _SHOULDER_BINS = 1.15, 3, 5
_SAMPLED_PIXELS = 2000
"""Number of evenly spread pixels by which a candidate's size is measured."""


@dataclass(frozen=True)
class CandidateParameters:
    """Limits of a person's size.

    Attributes:
        narrowest_m, widest_m: width across the line of sight, with clothes and the matcher's blocks.
        deepest_m: depth along it.
        widest_group_m, deepest_group_m: the same of several people who touch.
        widest_alone_m: a wider region is searched for several heads.
        least_head_m: least height of a head above its surroundings. heads_apart_m: least distance of two heads.
        widest_head_m: width of a head, with hair.
        lowest_top_m, highest_top_m: height of the highest point.
        least_surface_m2: visible surface.
        usual_height_m, usual_width_m: used where the picture's border cuts a person.
        plan: settings of the plan view.
    """

    narrowest_m: float = 0.25
    widest_m: float = 1.0
    deepest_m: float = 0.9
    widest_group_m: float = 1.8
    deepest_group_m: float = 1.2
    widest_alone_m: float = 0.7
    least_head_m: float = 0.1
    heads_apart_m: float = 0.3
    widest_head_m: float = 0.3
    lowest_top_m: float = 1.2
    highest_top_m: float = 2.05
    least_surface_m2: float = 0.12
    usual_height_m: float = 1.7
    usual_width_m: float = 0.5
    plan: PlanViewParameters = field(default_factory=PlanViewParameters)


@dataclass(frozen=True)
class Candidate:
    """A region that may be a person.

    Attributes:
        place_m: (2,) X ahead and Y to the left in the robot's frame: median of the visible surface.
        width_m, thickness_m: of the visible part, across and along the line of sight.
        height_m: height of the highest point; at least the usual height if the picture's border cuts it.
        surface_m2: visible surface, projected onto the picture plane.
        depth_m: distance along the camera's axis.
        box_xyxy: (4,) box in the left picture from the ground to the top, with hidden parts.
        pixels: (N,) indices of its pixels in the flattened depth picture.
        cut: whether the left or right border of the picture cuts it.
        top_cut: whether the top border cuts it.
    """

    place_m: NDArray[np.float64]
    width_m: float
    thickness_m: float
    height_m: float
    surface_m2: float
    depth_m: float
    box_xyxy: NDArray[np.float64]
    pixels: NDArray[np.int64]
    cut: bool
    top_cut: bool

    @property
    def centre_px(self) -> NDArray[np.float64]:
        """Centre (2,) of the box."""
        return 0.5 * (self.box_xyxy[:2] + self.box_xyxy[2:])


def find_candidates(
    points: NDArray[np.float32], camera: CameraModel, mounting: Mounting, parameters: CandidateParameters
) -> list[Candidate]:
    """Return the candidates of a point cloud (H', W', 3) in the robot's frame, in order of distance."""
    focal_baseline_m = camera.focal_px * baseline_m(camera)
    focal_px = camera.focal_px * points.shape[1] / camera.width_px
    plan = plan_view(points, focal_px, focal_baseline_m, parameters.plan)
    largest_m = (parameters.widest_m, parameters.deepest_m), (parameters.widest_group_m, parameters.deepest_group_m)
    regions = dense_regions(plan, *largest_m, parameters.plan).ravel()
    surface_m2 = np.bincount(regions, weights=plan.area_m2.ravel())
    regions[surface_m2[regions] < parameters.least_surface_m2] = 0
    # Index 0 for pixels in no cell.
    region_of_pixel = np.concatenate([[0], regions]).astype(np.uint16)[plan.cell_of_pixel.ravel() + 1]
    counted = np.flatnonzero(region_of_pixel)
    by_region = counted[np.argsort(region_of_pixel[counted], kind="stable")]
    ends = np.cumsum(np.bincount(region_of_pixel[counted], minlength=int(regions.max()) + 1))
    wholes = [pixels for pixels in np.split(by_region, ends[:-1]) if len(pixels)]
    people = [
        below_head_top(person, points, focal_px, parameters)
        for pixels in wholes
        for person in split_by_heads(pixels, points, parameters)
    ]
    measured = (_measure(pixels, points, camera, mounting, parameters) for pixels in people if len(pixels))
    found = [person for person in measured if person and may_be_person(person, parameters, focal_baseline_m)]
    return sorted(found, key=lambda candidate: candidate.depth_m)


def split_by_heads(
    pixels: NDArray[np.int64], points: NDArray[np.float32], parameters: CandidateParameters
) -> list[NDArray[np.int64]]:
    """Return the pixels of each person in a region; one wider than ``widest_alone_m`` may have several heads.

    Heads are peaks of the region's height profile across the line of sight; each pixel belongs to the nearest head.
    """
    p = parameters
    own = points.reshape(-1, 3)[pixels]
    x, y = own[:, :2].mean(axis=0) / max(float(np.hypot(*own[:, :2].mean(axis=0))), 1e-9)
    across_m = x * own[:, 1] - y * own[:, 0]
    bins = ((across_m - across_m.min()) / _HEAD_BIN_M).astype(np.intp)
    if bins.max() * _HEAD_BIN_M <= p.widest_alone_m:
        return [pixels]
    heights_m = np.zeros(bins.max() + 3)
    np.maximum.at(heights_m, bins + 1, own[:, 2])
    # The median of three bins removes single outliers.
    smooth_m = np.median([heights_m[:-2], heights_m[1:-1], heights_m[2:]], axis=0)
    smooth_m = np.concatenate([[0.0], smooth_m, [0.0]])
    # scipy.signal takes a second to import, which only trackers of this paper should cost.
    from scipy.signal import find_peaks

    heads, _ = find_peaks(smooth_m, prominence=p.least_head_m, distance=max(int(p.heads_apart_m / _HEAD_BIN_M), 1))
    if len(heads) < 2:
        return [pixels]
    nearest = np.argmin(np.abs(bins[:, None] - (heads - 1)[None]), axis=1)
    return [pixels[nearest == head] for head in np.unique(nearest)]


def below_head_top(
    pixels: NDArray[np.int64], points: NDArray[np.float32], focal_px: float, parameters: CandidateParameters
) -> NDArray[np.int64]:
    """Return a person's pixels without false matches of a uniform sky or wall above the head.

    Above a part as narrow as a head, all from the first wide row on is removed.

    Args:
        focal_px: focal length in pixels of the point cloud's picture.
    """
    p = parameters
    own = points.reshape(-1, 3)[pixels]
    rows = (own[:, 2] / _HEIGHT_BIN_M).astype(np.intp)
    widths_m = np.bincount(rows) * (float(own[:, 0].mean()) / focal_px) ** 2 / _HEIGHT_BIN_M
    wide = widths_m > _WIDE_AGAIN * p.widest_head_m
    shoulders = int(p.lowest_top_m / _HEIGHT_BIN_M)
    for neck in shoulders + np.flatnonzero(widths_m[shoulders:] < p.widest_head_m):
        again = neck + int(np.argmax(wide[neck:]))
        if wide[again]:
            is_head = again - neck >= _LEAST_HEAD_BINS and wide[neck - _SHOULDER_BINS : neck].any()
            return pixels[rows < again] if is_head else pixels
    return pixels


def may_be_person(candidate: Candidate, parameters: CandidateParameters, focal_baseline_m: float) -> bool:
    """Return whether a region has a person's size; a region cut by the border needs half the least width."""
    p = parameters
    narrowest_m = 0.5 * p.narrowest_m if candidate.cut else p.narrowest_m
    # Errors of the disparity lengthen people along the line of sight.
    spread_m = 4.0 * p.plan.disparity_noise_px * candidate.depth_m**2 / focal_baseline_m
    return (
        narrowest_m <= candidate.width_m <= p.widest_m
        and candidate.thickness_m <= p.deepest_m + spread_m
        and p.lowest_top_m <= candidate.height_m <= p.highest_top_m
        and candidate.surface_m2 >= p.least_surface_m2
    )


def _measure(
    pixels: NDArray[np.int64],
    points: NDArray[np.float32],
    camera: CameraModel,
    mounting: Mounting,
    parameters: CandidateParameters,
) -> Candidate | None:
    width = points.shape[1]
    sampled = pixels[:: len(pixels) // _SAMPLED_PIXELS + 1]
    own = points.reshape(-1, 3)[sampled].astype(np.float64)
    # The median: arms and points between a person and the background shift a mean.
    place_m = np.median(own[:, :2], axis=0)
    depth_m = mounting.depth_m(np.append(place_m, mounting.height_m))
    if depth_m <= 0.0:
        return None
    cosine, sine = place_m / np.hypot(*place_m)
    across = np.percentile(cosine * own[:, 1] - sine * own[:, 0], (2, 98))
    along = np.percentile(cosine * own[:, 0] + sine * own[:, 1], (5, 95))
    rows, columns = np.divmod(sampled, width)
    shrink = camera.width_px / width
    left, right = np.percentile(columns, (1, 99))
    # The other camera does not see a strip on the left as wide as the disparity.
    unseen = camera.focal_px * baseline_m(camera) / depth_m / shrink
    left_cut, right_cut = bool(left < unseen + _BORDER_PX), bool(right >= width - 1 - _BORDER_PX)
    top_cut = bool(np.percentile(rows, 0.5) < _BORDER_PX)
    seen_top_m = float(np.percentile(own[:, 2], 99.5))
    top_m = max(parameters.usual_height_m, seen_top_m) if top_cut else seen_top_m
    usual_px = parameters.usual_width_m * camera.focal_px / depth_m
    x_min, x_max = shrink * left, shrink * (right + 1.0)
    if left_cut and not right_cut:
        x_min = min(x_min, x_max - usual_px)
    if right_cut and not left_cut:
        x_max = max(x_max, x_min + usual_px)
    feet_and_top = mounting.pixels(np.column_stack([np.tile(place_m, (2, 1)), [0.0, top_m]]), camera)
    return Candidate(
        place_m=place_m,
        width_m=float(np.ptp(across)),
        thickness_m=float(np.ptp(along)),
        height_m=top_m,
        surface_m2=len(pixels) * (depth_m * shrink / camera.focal_px) ** 2,
        depth_m=depth_m,
        box_xyxy=np.array([x_min, feet_and_top[1, 1], x_max, feet_and_top[0, 1]]),
        pixels=pixels,
        cut=left_cut or right_cut,
        top_cut=top_cut,
    )


def candidate_in_box(candidates: list[Candidate], box_xyxy: NDArray[np.float64]) -> Candidate | None:
    """Return the candidate whose box overlaps a box (4,) most; None if no intersection over union exceeds 0.5."""
    size = box_size(box_xyxy)
    best, best_overlap = None, 0.5
    for candidate in candidates:
        box = candidate.box_xyxy
        shared = np.maximum(np.minimum(box[2:], box_xyxy[2:]) - np.maximum(box[:2], box_xyxy[:2]), 0.0).prod()
        overlap = float(shared / (np.prod(box[2:] - box[:2]) + size.prod() - shared))
        if overlap > best_overlap:
            best, best_overlap = candidate, overlap
    return best
