"""Boxes ``(x_min, y_min, x_max, y_max)`` in pixels, not limited to the picture, and cars in them."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def box_centre(box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centre (2,) of a box (4,)."""
    return 0.5 * (box_xyxy[:2] + box_xyxy[2:])


def box_size(box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (width, height) of a box (4,), each at least one pixel.

    Raises:
        ValueError: if the box is not four finite numbers with x_min < x_max and y_min < y_max.
    """
    box_xyxy = np.asarray(box_xyxy, dtype=float)
    if box_xyxy.shape != (4,) or not np.isfinite(box_xyxy).all() or not (box_xyxy[:2] < box_xyxy[2:]).all():
        raise ValueError(
            "box_xyxy: expected four finite numbers (x_min, y_min, x_max, y_max) with x_min < x_max and "
            f"y_min < y_max, got {box_xyxy.tolist()}"
        )
    return np.maximum(box_xyxy[2:] - box_xyxy[:2], 1.0)


def box_around(centre_px: NDArray[np.float64], size_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the box (4,) of size (width, height) around a centre (2,)."""
    return np.concatenate([centre_px - 0.5 * size_px, centre_px + 0.5 * size_px])


def inside_picture(points_px: NDArray[np.float64], width_px: int, height_px: int) -> NDArray[np.bool_]:
    """Return for each of the points (..., 2) whether it lies in ``[0, width) x [0, height)``; NaN does not."""
    inside = np.empty(points_px.shape[:-1], np.bool_)
    _inside(points_px.reshape(-1, 2), width_px, height_px, inside.reshape(-1))
    return inside


@njit(cache=True)
def _inside(points_px: NDArray[np.float64], width_px: float, height_px: float, inside: NDArray[np.bool_]) -> None:
    for n in range(len(points_px)):
        x, y = points_px[n]
        inside[n] = x >= 0 and x < width_px and y >= 0 and y < height_px


def box_iou(first_xyxy: NDArray[np.float64], second_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the intersection over union of boxes (..., 4), which broadcast: area(A n B) / area(A u B), in [0, 1].

    0 where either box has no area or holds NaN.
    """
    low = np.maximum(first_xyxy[..., :2], second_xyxy[..., :2])
    high = np.minimum(first_xyxy[..., 2:], second_xyxy[..., 2:])
    with np.errstate(invalid="ignore", divide="ignore"):
        shared = np.prod(np.clip(high - low, 0.0, None), axis=-1)
        areas = [np.prod(np.clip(box[..., 2:] - box[..., :2], 0.0, None), axis=-1) for box in (first_xyxy, second_xyxy)]
        iou = shared / (areas[0] + areas[1] - shared)
    return np.where((areas[0] > 0) & (areas[1] > 0), np.nan_to_num(iou, nan=0.0), 0.0)


def intersections_over_union(first_xyxy: NDArray[np.float64], second_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N, M) ``box_iou`` of each of the boxes (N, 4) and each of the boxes (M, 4)."""
    return box_iou(first_xyxy[:, None], second_xyxy[None])


WIDTH_TO_LENGTH = 0.42
"""Of a car."""


def apparent_length_px(box_xyxy: NDArray[np.float64]) -> float:
    """Return the length of a car that fills an upright box (4,)."""
    return float(np.hypot(*length_parts_px(box_xyxy)))


def length_parts_px(box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (2,) L |cos| and L |sin| of a car of length L and width r L in an upright box W x H.

    ``W = L (|cos| + r |sin|)``, ``H = L (|sin| + r |cos|)``.
    """
    size_px = box_xyxy[2:] - box_xyxy[:2]
    return np.maximum((size_px - WIDTH_TO_LENGTH * size_px[::-1]) / (1.0 - WIDTH_TO_LENGTH**2), 0.0)
