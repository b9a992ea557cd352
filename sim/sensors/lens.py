"""The lens: radial distortion and scattered light."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.optics import PinholeCamera
from sim.render.compilation import row_kernel


def distort(radiance: NDArray[np.float32], camera: PinholeCamera) -> NDArray[np.float32]:
    """Return the radiance (H, 3, W) as the lens bends it; ``radiance`` itself for a lens without distortion.

    Light that belongs at the normalised image point x arrives at ``x (1 + k1 r² + k2 r⁴)``, r = |x| (Brown
    1966).
    """
    if camera.radial_distortion == (0.0, 0.0):
        return radiance
    map_x, map_y = _undistorted_positions(camera)
    bent = np.empty_like(radiance)
    for channel in range(3):
        plane = np.ascontiguousarray(radiance[:, channel])
        bent[:, channel] = cv2.remap(plane, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return bent


def veil(metered: NDArray[np.float64], share: float) -> NDArray[np.float32]:
    """Return the light (3,) that lens and housing spread evenly over a picture, given its mean radiance (3,).

    A share of all light is scattered (veiling glare, ISO 9358): ``L' = (1 - share) L + share mean(L)``, of which this
    is the last part.
    """
    return (share * metered).astype(np.float32)


@row_kernel()
def scatter_row(
    radiance: NDArray[np.float32], share: np.float32, veil: NDArray[np.float32], scattered: NDArray[np.float32]
) -> None:
    """Write ``(1 - share) L + veil`` of one row (3, W)."""
    kept = np.float32(1.0) - share
    for channel in range(3):
        line, into, more = radiance[channel], scattered[channel], veil[channel]
        for k in range(line.shape[0]):
            into[k] = kept * line[k] + more


@lru_cache(maxsize=4)
def _undistorted_positions(camera: PinholeCamera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where in the undistorted picture each pixel's light comes from: (column, row) arrays (H, W).

    Solves ``r_d = r (1 + k1 r² + k2 r⁴)`` for r by Newton's method.
    """
    k1, k2 = camera.radial_distortion
    x = (np.arange(camera.width_px) + 0.5 - 0.5 * camera.width_px) / camera.focal_px
    y = (np.arange(camera.height_px) + 0.5 - 0.5 * camera.height_px) / camera.focal_px
    x, y = np.meshgrid(x, y)
    r_distorted = np.hypot(x, y)
    r = r_distorted.copy()
    for _ in range(20):
        error = r * (1 + k1 * r**2 + k2 * r**4) - r_distorted
        r -= error / (1 + 3 * k1 * r**2 + 5 * k2 * r**4)
    scale = np.where(r_distorted > 0, r / np.maximum(r_distorted, 1e-12), 1.0) * camera.focal_px
    map_x = x * scale + 0.5 * camera.width_px - 0.5
    map_y = y * scale + 0.5 * camera.height_px - 0.5
    return map_x.astype(np.float32), map_y.astype(np.float32)
