"""Small sequences on disk: a red box that runs to the right, leaves the picture, and returns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH_PX, HEIGHT_PX = 64, 48
FRAMES = 60
AWAY = range(15, 20)
"""Frames on which the box is outside."""
NONE = np.full(4, np.nan)


def true_boxes(frames: int = FRAMES, away: range = AWAY) -> NDArray[np.float64]:
    """Return the boxes (F, 4) x_min, y_min, x_max, y_max; NaN while it is away."""
    boxes = np.array([[4.0 + k % 40, 20.0, 16.0 + k % 40, 28.0] for k in range(frames)])
    boxes[[k for k in away if k < frames]] = np.nan
    return boxes


def write_pictures(
    folder: Path, boxes: Sequence[NDArray[np.float64]], name: str = "{:04d}.png", first: int = 1
) -> None:
    """Write a picture for each box, numbered from ``first``."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, box in enumerate(boxes, start=first):
        picture = np.full((HEIGHT_PX, WIDTH_PX, 3), (90, 110, 70), np.uint8)
        if not np.isnan(box).any():
            x_min, y_min, x_max, y_max = box.astype(int)
            picture[y_min:y_max, x_min:x_max] = (20, 20, 220)
        cv2.imwrite(str(folder / name.format(number)), picture)


def lines_of(boxes: NDArray[np.float64], separator: str = ",") -> list[str]:
    """Return left, top, width, height of each box as text, where the first pixel is at 1, 1."""
    rows = [[x + 1, y + 1, right - x, bottom - y] for x, y, right, bottom in boxes]
    return [separator.join("NaN" if np.isnan(number) else f"{number:g}" for number in row) for row in rows]


def write_lines(path: Path, lines: Sequence[str]) -> Path:
    """Write lines into a file, with its folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{line}\n" for line in lines))
    return path


def write_otb(folder: Path, boxes: NDArray[np.float64] | None = None) -> Path:
    """Write a sequence in the layout of OTB."""
    boxes = true_boxes() if boxes is None else boxes
    write_pictures(folder / "img", list(boxes))
    write_lines(folder / "groundtruth_rect.txt", lines_of(boxes))
    return folder
