"""Check of a gap method's answer against its contract."""

from __future__ import annotations

import numpy as np

from trackers.gaps.types import Bridge


def check_bridge(bridge: Bridge, count: int) -> None:
    """Raise ValueError, naming the field, what was expected and what came, if a bridge over ``count`` frames is broken.

    Positions and covariances must be finite: a method without an answer returns None.
    """
    if not isinstance(bridge, Bridge):
        raise ValueError(f"bridge: expected a Bridge or None, got {type(bridge).__name__}")
    _check_array("position_px", bridge.position_px, (count, 2))
    if bridge.covariance_px is not None:
        _check_array("covariance_px", bridge.covariance_px, (count, 2, 2))
        scale = 1e-6 * np.maximum(np.abs(bridge.covariance_px).max(axis=(1, 2), initial=0.0), 1e-12)
        skew = np.abs(bridge.covariance_px[:, 0, 1] - bridge.covariance_px[:, 1, 0])
        if (skew > scale).any() or (np.linalg.eigvalsh(bridge.covariance_px)[:, 0] < -scale).any():
            raise ValueError("covariance_px: expected symmetric matrices without negative eigenvalues, got others")


def _check_array(name: str, value: object, shape: tuple[int, ...]) -> None:
    array = np.asarray(value)
    if array.shape != shape or array.dtype.kind != "f":
        raise ValueError(f"{name}: expected floating-point numbers of shape {shape}, got {array.dtype} {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got {int((~np.isfinite(array)).sum())} that are not")
