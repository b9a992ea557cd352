"""Check of a gap method's answer against its contract."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.gaps.types import Bridge


def check_bridge(bridge: Bridge, count: int) -> Bridge:
    """Return a bridge over ``count`` frames with arrays of its own.

    Positions and covariances must be finite: a method without an answer returns None.

    Raises:
        ValueError: if it breaks its contract; names the field, what was expected and what came.
    """
    if not isinstance(bridge, Bridge):
        raise ValueError(f"bridge: expected a Bridge or None, got {type(bridge).__name__}")
    position = _array("position_px", bridge.position_px, (count, 2))
    if bridge.covariance_px is None:
        return Bridge(position)
    covariance = _array("covariance_px", bridge.covariance_px, (count, 2, 2))
    scale = 1e-6 * np.maximum(np.abs(covariance).max(axis=(1, 2), initial=0.0), 1e-12)
    skew = np.abs(covariance[:, 0, 1] - covariance[:, 1, 0])
    if (skew > scale).any() or (np.linalg.eigvalsh(covariance)[:, 0] < -scale).any():
        raise ValueError("covariance_px: expected symmetric matrices without negative eigenvalues, got others")
    return Bridge(position, covariance)


def _array(name: str, value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.array(value)
    if array.shape != shape or array.dtype.kind != "f":
        raise ValueError(f"{name}: expected floating-point numbers of shape {shape}, got {array.dtype} {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got {int((~np.isfinite(array)).sum())} that are not")
    return array
