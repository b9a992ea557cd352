"""KITTI's 16-bit PNG maps (development kit of the stereo and flow benchmarks, https://www.cvlibs.net/datasets/kitti)."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

_FRACTIONS, _FLOW_FRACTIONS, _FLOW_ZERO, _LARGEST = 256.0, 64.0, 2**15, 2**16 - 1


def distance_map(values: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Return a map (H, W) of depths in metres or disparities in pixels as KITTI stores it: 256 steps a unit.

    0 means "no value": where none is finite and > 0, or it is beyond the largest, 255.996. A value that rounds to 0
    becomes 1, as in KITTI's own writer.
    """
    stored = np.maximum(np.rint(np.nan_to_num(values, nan=np.inf, posinf=np.inf) * _FRACTIONS), 1.0)
    good = (values > 0) & (stored <= _LARGEST)
    return np.where(good, stored, 0.0).astype(np.uint16)


def flow_map(flow_px: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Return a flow (H, W, 2), x right and y down in pixels, as (H, W, 3): 64 x + 2^15, 64 y + 2^15, 1 where valid.

    All three are 0 where the flow is not finite or beyond the range of 16 bits.
    """
    stored = np.rint(np.nan_to_num(flow_px, nan=np.inf, posinf=np.inf, neginf=-np.inf) * _FLOW_FRACTIONS + _FLOW_ZERO)
    good = ((stored >= 0) & (stored <= _LARGEST)).all(axis=2, keepdims=True)
    return np.where(good, np.concatenate([stored, np.ones_like(good)], axis=2), 0.0).astype(np.uint16)


def write_png16(values: NDArray[np.uint16], path: Path) -> None:
    """Write a map (H, W) or (H, W, 3), its channels in the order red, green, blue, as a PNG file."""
    swapped = values if values.ndim == 2 else np.ascontiguousarray(values[..., ::-1])
    path.write_bytes(cv2.imencode(".png", swapped)[1].tobytes())
