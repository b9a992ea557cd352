"""A car in an upright box of a picture from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
