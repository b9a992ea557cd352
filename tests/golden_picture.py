"""Comparison of finished pictures with kept ones.

A pixel may differ by 1 of 255. One in 2,000 may differ by more: another processor rounds elsewhere, so that a point
falls on the other side of an edge. Where a test fails, the picture and the (tenfold) difference are left in
``results/golden``; ``pytest --new-golden`` makes the kept pictures anew, which then must be looked at.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

KEPT = Path(__file__).parent / "golden"
FAILED = Path(__file__).parent.parent / "results" / "golden"


def differences(picture: NDArray[np.uint8], kept: NDArray[np.uint8]) -> tuple[float, NDArray[np.int64]]:
    """Return the share of pixels that differ by more than 1, and the difference (H, W, 3)."""
    difference = np.abs(picture.astype(int) - kept)
    return float((difference.max(axis=-1) > 1).mean()), difference


def require_kept(picture: NDArray[np.uint8], name: str, request: pytest.FixtureRequest) -> None:
    """Compare a picture (H, W, 3) with the kept one of this name, or keep it with ``--new-golden``."""
    path = KEPT / f"{name}.png"
    if request.config.getoption("--new-golden"):
        cv2.imwrite(str(path), picture[..., ::-1])
        pytest.skip(f"{path} made anew")
    wrong, difference = differences(picture, cv2.imread(str(path))[..., ::-1])
    if wrong > 5e-4:
        FAILED.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(FAILED / f"{name}.png"), picture[..., ::-1])
        tenfold = np.clip(10 * difference, 0, 255).astype(np.uint8)
        cv2.imwrite(str(FAILED / f"{name}-difference.png"), tenfold[..., ::-1])
    assert wrong <= 5e-4
