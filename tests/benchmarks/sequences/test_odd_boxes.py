"""Boxes in other units, or of corners, are told; boxes of the layout are not, at any border of the picture."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.sequences.odd_boxes import odd_boxes
from benchmarks.sequences.sequence import BoxedSequence, Collection

WIDTH, HEIGHT = 160, 120
LEFT = np.arange(0.0, 136.0, 8.0)
BOXES_XYWH = np.stack([LEFT, 100.0 - 0.7 * LEFT, np.full_like(LEFT, 24.0), np.full_like(LEFT, 20.0)], axis=1)
GROWING_XYWH = np.stack([LEFT, LEFT, LEFT + 24, LEFT + 20], axis=1)


def told(folder: Path, boxes_xywh: NDArray[np.float64]) -> list[str]:
    picture = folder / "0001.png"
    cv2.imwrite(str(picture), np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    boxes_xyxy = np.hstack([boxes_xywh[:, :2], boxes_xywh[:, :2] + boxes_xywh[:, 2:]])
    sequence = BoxedSequence("car", (picture,) * len(boxes_xyxy), boxes_xyxy)
    return list(odd_boxes([Collection("mine", (sequence,))]))


@pytest.mark.parametrize(
    "boxes_xywh",
    [
        BOXES_XYWH,
        BOXES_XYWH + np.array([30.0, 0.0, 0.0, 0.0]),
        np.where(np.arange(len(LEFT))[:, None] % 2, np.nan, BOXES_XYWH),
        np.tile([0.0, 0.0, WIDTH, HEIGHT], (9, 1)),
        np.tile([3.0, 4.0, 24.0, 20.0], (9, 1)),
    ],
)
def test_boxes_of_the_layout_are_not_odd(tmp_path: Path, boxes_xywh: NDArray[np.float64]) -> None:
    # The last one leaves the picture by a part.
    assert told(tmp_path, boxes_xywh[:-4]) == []


@pytest.mark.parametrize(
    ("boxes_xywh", "words"),
    [
        (GROWING_XYWH, "car: in 10 of 17 pictures the box reaches beyond the picture: are these left, top, width"),
        (BOXES_XYWH / WIDTH, "car: in 17 of 17 pictures the box lies in the first pixel, from 0 to 1: are these left"),
        (BOXES_XYWH + (BOXES_XYWH > 90) * 5000.0, "car: in 7 of 17 pictures the box lies outside the picture: are"),
    ],
)
def test_boxes_of_another_kind_are_told(tmp_path: Path, boxes_xywh: NDArray[np.float64], words: str) -> None:
    (line,) = told(tmp_path, boxes_xywh)
    assert line.startswith(words)
