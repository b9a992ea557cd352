"""Optical flow of corners, and the misfit of a camera motion to it (paper A, section 4.2)."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

_WINDOW_PX = (21, 21)
_PYRAMID_LEVELS = 3


def find_corners(grey: NDArray[np.uint8], corners: int, border_px: int) -> NDArray[np.float64]:
    """Return Harris corners (M, 2) of a picture (H, W), in pixels from its top left corner.

    At most ``corners``, the strongest first, at least 12 pixels apart and ``border_px`` from the border.
    """
    mask = np.zeros_like(grey)
    height, width = grey.shape
    mask[border_px : height - border_px, border_px : width - border_px] = 255
    found = cv2.goodFeaturesToTrack(grey, corners, 0.001, 12, mask=mask, useHarrisDetector=True, k=0.04)
    # OpenCV's origin is the middle of the first pixel, ours its corner.
    return np.empty((0, 2)) if found is None else found.reshape(-1, 2).astype(float) + 0.5


def follow_corners(
    grey_before: NDArray[np.uint8],
    grey_after: NDArray[np.uint8],
    corners_px: NDArray[np.float64],
    expected_px: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Track corners (M, 2) from one picture (H, W) to the next by the pyramidal Kanade-Lucas-Tomasi method.

    The search starts at the expected positions (M, 2) and reaches about 40 pixels from there.

    Returns:
        the corners that were tracked (K, 2) and their flow (K, 2).
    """
    if len(corners_px) == 0:
        return np.empty((0, 2)), np.empty((0, 2))
    start, guess = ((points - 0.5).astype(np.float32).reshape(-1, 1, 2) for points in (corners_px, expected_px))
    followed, status, _ = cv2.calcOpticalFlowPyrLK(
        grey_before,
        grey_after,
        start,
        guess,
        winSize=_WINDOW_PX,
        maxLevel=_PYRAMID_LEVELS,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    kept = status.ravel() == 1
    return corners_px[kept], (followed - start).reshape(-1, 2)[kept].astype(float)


@njit(cache=True, fastmath={"nsz", "contract", "reassoc"})
def flow_misfits(
    motions: NDArray[np.float64], corners_px: NDArray[np.float64], flow_px: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``sum_i |V_i - V(hx_n)|`` of each motion, where V(hx) is ``u = -Vx + ω Y, v = -Vy - ω X``.

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
