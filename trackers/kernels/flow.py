"""Optical flow of corners, and how well a motion of the camera explains it (paper A, section 4.2)."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

_WINDOW_PX = (15, 15)
_PYRAMID_LEVELS = 4


def corner_flow(
    grey_before: NDArray[np.uint8], grey_after: NDArray[np.uint8], corners: int, border_px: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find Harris corners in one picture and follow them into the next by pyramidal Kanade-Lucas-Tomasi.

    Args:
        grey_before, grey_after: (H, W) each.
        corners: most corners to find, the strongest first, at least 12 pixels apart.
        border_px: corners nearer to the border than this are dropped.

    Returns:
        corners (M, 2) in pixels from the top left corner of the picture, and their flow (M, 2); only those followed.
    """
    mask = np.zeros_like(grey_before)
    mask[border_px:-border_px, border_px:-border_px] = 255
    found = cv2.goodFeaturesToTrack(grey_before, corners, 0.001, 12, mask=mask, useHarrisDetector=True, k=0.04)
    if found is None or len(found) == 0:
        return np.empty((0, 2)), np.empty((0, 2))
    followed, status, _ = cv2.calcOpticalFlowPyrLK(
        grey_before, grey_after, found, None, winSize=_WINDOW_PX, maxLevel=_PYRAMID_LEVELS
    )
    kept = status.ravel() == 1
    before = found.reshape(-1, 2)[kept].astype(float)
    # OpenCV's coordinates count from the middle of the first pixel, ours from its corner.
    return before + 0.5, followed.reshape(-1, 2)[kept].astype(float) - before


@njit(cache=True, fastmath={"nsz", "contract", "reassoc"})
def flow_misfits(
    motions: NDArray[np.float64], corners_px: NDArray[np.float64], flow_px: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``sum_i |V_i - V(hx_n)|`` for each motion, where V(hx) is ``u = -Vx + ω Y, v = -Vy - ω X``.

    Args:
        motions: (N, 3) of (Vx, Vy, ω) in pixels and radians a frame.
        corners_px: (M, 2) corners (X, Y) from the image centre.
        flow_px: (M, 2) their flow V = (u, v).

    Returns:
        (N,) pixels; zeros if M = 0.

    Source: paper A, equations 4.17 and 4.18. The paper prints ``v = -vy + ω X``; a rotation needs the minus.
    """
    misfits = np.zeros(len(motions))
    for n in range(len(motions)):
        speed_x, speed_y, turn = motions[n]
        total = 0.0
        for i in range(len(corners_px)):
            u = -speed_x + turn * corners_px[i, 1]
            v = -speed_y - turn * corners_px[i, 0]
            total += np.sqrt((flow_px[i, 0] - u) ** 2 + (flow_px[i, 1] - v) ** 2)
        misfits[n] = total
    return misfits
