"""Frame-outs of the target, in the geometry of its box and the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel

IN, PARTIAL, OUT = 0, 1, 2


def picture_states(
    camera: CameraModel, poses: NDArray[np.float64], corners_world_m: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return IN, PARTIAL or OUT for the box around ``corners_world_m`` (T, K, 3) in each frame (T,)."""
    points_camera = np.einsum("tkj,tji->tki", corners_world_m - poses[:, None, :3, 3], poses[:, :3, :3])
    behind = (points_camera[..., 2] <= 1e-6).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = camera.focal_px * points_camera[..., :2] / points_camera[..., 2:] + camera.centre_px
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    size = (camera.width_px, camera.height_px)
    out = behind | (high <= 0).any(axis=1) | (low >= size).any(axis=1)
    whole = (low >= 0).all(axis=1) & (high <= size).all(axis=1)
    return np.where(out, OUT, np.where(whole, IN, PARTIAL))


def frame_out_spans(states: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return (first frame out, first frame after it that is not out) of every stretch of OUT."""
    out = np.concatenate([[False], states == OUT, [False]])
    edges = np.flatnonzero(out[1:] != out[:-1])
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
