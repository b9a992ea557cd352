"""Boxes of objects on a picture: outlines of what is seen of them, corners of the whole object, names and states."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.page.channel_pictures import Rgb
from benchmarks.show.video import marks
from scenarios.truth import Truth

VISIBLE, AMODAL = marks.TRUTH, marks.ESTIMATE
"""Colours of visible boxes and of amodal ones."""
STANDING_RGB = (204, 121, 167)
"""Colour of the visible boxes of what stands about."""
_LABEL_SIZE, _LABEL_PX = 13, 17
"""Size of a label's letters, and its height."""
_LABELLED_FROM_PX = 26.0
"""Width of a box from which on any object has a label; the target always has."""
_THICK_FROM_PX = 40.0
"""Width of a box from which on the target's is drawn thick."""
_INSIDE = ("in", "partial", "occluded")


def zoomed(image: Rgb, width_px: int) -> Rgb:
    """Return a picture (h, w, 3) scaled to a width; pixels stay sharp where it grows."""
    height = round(width_px * image.shape[0] / image.shape[1])
    # Whole steps first: other factors would make some pixels wider than others.
    whole = -(-width_px // image.shape[1])
    if whole > 1:
        image = np.asarray(cv2.resize(image, None, fx=whole, fy=whole, interpolation=cv2.INTER_NEAREST), np.uint8)
    return np.asarray(cv2.resize(image, (width_px, height), interpolation=cv2.INTER_AREA), np.uint8)


def draw_boxes(image: Rgb, zoom: float, truth: Truth, visible_xyxy: NDArray[np.float64], target: str) -> None:
    """Draw the boxes of all objects that are at least in part within the borders; an arrow points to a target outside.

    Args:
        image: the frame's picture at ``zoom`` times its size.
        visible_xyxy: (N, 4) boxes of the visible pixels, NaN where there are none.
        target: its name; nothing special if no object has it.
    """
    inside = np.flatnonzero(np.isin(truth.state, _INSIDE))
    widths = np.nan_to_num(truth.box_xyxy[:, 2] - truth.box_xyxy[:, 0]) * zoom
    is_target = np.array([name == target for name in truth.names])
    for k in inside:
        # Corners of a few pixels would hide what they are about.
        if widths[k] >= _LABELLED_FROM_PX or is_target[k]:
            marks.draw_corners(image, truth.box_xyxy[k] * zoom, AMODAL, 1)
    for k in inside:
        # A thick line would cover a small object.
        marks.draw_box(image, visible_xyxy[k] * zoom, VISIBLE, 2 if is_target[k] and widths[k] >= _THICK_FROM_PX else 1)
    taken: list[tuple[int, int, int]] = []
    for k in sorted(inside, key=lambda k: (not is_target[k], -widths[k])):
        if is_target[k] or widths[k] >= _LABELLED_FROM_PX:
            state = str(truth.state[k])
            words = truth.names[k] if state == "in" else f"{truth.names[k]} {state}"
            _draw_label(image, truth.box_xyxy[k] * zoom, words, taken)
    for k in np.flatnonzero(is_target & (truth.state == "out")):
        marks.draw_pointer(image, truth.position_px[k] * zoom, VISIBLE)


def _draw_label(image: Rgb, box_xyxy: NDArray[np.float64], words: str, taken: list[tuple[int, int, int]]) -> None:
    """Write above a box, or below it at the upper border; not over another label (x from, x to, y of ``taken``)."""
    if not np.isfinite(box_xyxy).all():
        return
    height, width = image.shape[:2]
    length = marks.text_width_px(words, size=_LABEL_SIZE) + 6
    x = int(np.clip(box_xyxy[0], 0, max(width - length, 0)))
    above = box_xyxy[1] - _LABEL_PX - 2
    y = int(np.clip(above if above >= 0 else box_xyxy[3] + 2, 0, height - _LABEL_PX))
    if any(x < to and since < x + length and abs(y - row) < _LABEL_PX for since, to, row in taken):
        return
    taken.append((x, x + length, y))
    marks.draw_label(image, (x + 3, y + 13), words, marks.OBSERVED, size=_LABEL_SIZE)
