"""Any channel as a picture to look at: colours follow from its values' type, shape and meaning alone."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.channels import NORMALS
from scenarios.truth import Meaning

Rgb = NDArray[np.uint8]

EMPTY = (28, 30, 35)
"""Colour of pixels without a value."""
_SHARES = (1.0, 99.0)
"""Percentiles at the ends of a scale."""
_LOG_FROM = 8.0
"""Ratio of its ends from which on a scale is logarithmic."""
_GOLDEN = 0.618034
"""Steps of this size about the circle of hues keep neighbouring numbers apart."""


def channel_picture(
    channel: str, value: NDArray[Any], meaning: Meaning | None, instance_id: NDArray[np.int64]
) -> tuple[Rgb, str]:
    """Return a channel's values (H, W, …) as a picture (H, W, 3), and the range of its values in words.

    Args:
        meaning: None for the channels that are no field of truth.
        instance_id: (N,) of the objects; in maps of ids all else is pale.
    """
    if value.ndim == 3 and value.dtype == np.uint8:
        return np.ascontiguousarray(value), ""
    if channel == NORMALS or (value.ndim == 3 and value.shape[2] == 3):
        return _directions(value), ""
    if value.ndim == 3:
        return _motions(value, "" if meaning is None else meaning.unit)
    if meaning is not None and meaning.unit in ("id", "word"):
        return _identities(value, instance_id), ""
    if meaning is None:
        return _greys(value)
    return _scale(value.astype(np.float64), meaning.unit)


def _greys(value: NDArray[Any]) -> tuple[Rgb, str]:
    low, high = np.percentile(value, _SHARES)
    grey = np.clip((value - low) * (255.0 / max(high - low, 1e-12)), 0, 255).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2), f"{low:,.0f} to {high:,.0f}"


def _scale(value: NDArray[np.float64], unit: str) -> tuple[Rgb, str]:
    known = np.isfinite(value)
    if not known.any():
        return _painted(np.zeros((*value.shape, 3), np.uint8), known), "no values"
    low, high = np.percentile(value[known], _SHARES)
    log = low > 0 and high / low >= _LOG_FROM
    if log:
        shares = np.log(np.clip(np.where(known, value, low), low, high) / low) / np.log(high / low)
    else:
        shares = (np.clip(np.where(known, value, low), low, high) - low) / max(high - low, 1e-12)
    image = cv2.applyColorMap((255 * shares).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    sign = "" if unit == "1" else f" {unit}"
    return _painted(image, known), f"{low:.3g} to {high:.3g}{sign}{', log' if log else ''}"


def _identities(value: NDArray[Any], instance_id: NDArray[np.int64]) -> Rgb:
    ids, places = np.unique(value, return_inverse=True)
    objects = np.sort(instance_id)
    of_object = np.isin(ids, objects)
    # Objects count from 0, so that ids in equal steps do not fall on neighbouring hues.
    number = np.where(of_object, np.searchsorted(objects, ids), ids).astype(np.float64)
    hsv = np.empty((1, len(ids), 3), dtype=np.float32)
    hsv[0, :, 0] = 360.0 * (number * _GOLDEN % 1.0)
    hsv[0, :, 1] = np.where(of_object, 0.75, 0.10)
    hsv[0, :, 2] = np.where(of_object, 0.95, 0.25 + 0.25 * (number * _GOLDEN**2 % 1.0))
    colours = np.rint(255 * cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0]).astype(np.uint8)
    return colours[places.reshape(value.shape)]


def _directions(value: NDArray[Any]) -> Rgb:
    known = np.isfinite(value).all(axis=2) & (value != 0).any(axis=2)
    return _painted(np.clip(127.5 * (np.nan_to_num(value) + 1.0), 0, 255).astype(np.uint8), known)


def _motions(value: NDArray[Any], unit: str) -> tuple[Rgb, str]:
    """Hue is the direction of the first two components, saturation their length."""
    known = np.isfinite(value).all(axis=2)
    x, y = np.moveaxis(np.where(known[..., None], value, 0.0)[..., :2].astype(np.float64), 2, 0)
    length = np.hypot(x, y)
    longest = max(float(np.percentile(length[known], _SHARES[1])) if known.any() else 0.0, 1e-9)
    hsv = np.empty((*known.shape, 3), dtype=np.float32)
    hsv[..., 0] = np.degrees(np.arctan2(y, x)) % 360.0
    hsv[..., 1] = np.clip(length / longest, 0.0, 1.0)
    hsv[..., 2] = 0.95
    image = np.rint(255 * cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)).astype(np.uint8)
    return _painted(image, known), f"0 to {longest:.3g} {unit}"


def _painted(image: NDArray[Any], known: NDArray[np.bool_]) -> Rgb:
    painted: Rgb = np.where(known[..., None], image, np.array(EMPTY, np.uint8)).astype(np.uint8)
    return painted
