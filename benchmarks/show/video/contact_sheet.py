"""Contact sheets: pictures in rows, each under its text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.show.video import marks
from benchmarks.show.video.instant import Instant, describe_state, draw_instant

_GAP_PX = 6
_STRIP_PX = 28
_GROUND = (24, 26, 31)
_INK = (240, 242, 246)


def contact_sheet(rows: Mapping[str, Sequence[Instant]], cell_width_px: int = 600) -> NDArray[np.uint8]:
    """Return the same instants of an episode side by side, a row for each tracker: (H, W, 3) uint8.

    Args:
        rows: tracker → instants, equally many and of one size.
        cell_width_px: width of one picture.
    """
    return _in_rows([[_instant_cell(tracker, each, cell_width_px) for each in rows[tracker]] for tracker in rows])


def picture_sheet(
    rows: Sequence[Sequence[tuple[str, NDArray[np.uint8]]]], cell_width_px: int = 240
) -> NDArray[np.uint8]:
    """Return pictures (h, w, 3), all of one size, under their text: (H, W, 3) uint8.

    Args:
        rows: of (text, picture), equally many in each.
        cell_width_px: width of one picture.
    """
    return _in_rows([[_picture_cell(words, image, cell_width_px) for words, image in row] for row in rows])


def _in_rows(cells: Sequence[Sequence[NDArray[np.uint8]]]) -> NDArray[np.uint8]:
    sheet = np.concatenate([np.concatenate(row, axis=1) for row in cells], axis=0)
    return sheet[:-_GAP_PX, :-_GAP_PX]


def _picture_cell(words: str, image_rgb: NDArray[np.uint8], width_px: int) -> NDArray[np.uint8]:
    size = (width_px, round(width_px * image_rgb.shape[0] / image_rgb.shape[1]))
    cell = _under_a_strip(np.asarray(cv2.resize(image_rgb, size, interpolation=cv2.INTER_AREA), np.uint8))
    marks.draw_text(cell, (4, 20), words, _INK, size=14, weight=600)
    return cell


def _under_a_strip(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width = image.shape[:2]
    cell = np.full((_STRIP_PX + height + _GAP_PX, width + _GAP_PX, 3), _GROUND, dtype=np.uint8)
    cell[_STRIP_PX : _STRIP_PX + height, :width] = image
    return cell


def _instant_cell(tracker: str, instant: Instant, width_px: int) -> NDArray[np.uint8]:
    cell = _under_a_strip(draw_instant(instant, zoom=width_px / instant.larger_view_rgb.shape[1]))
    x = marks.draw_text(cell, (4, 20), tracker, marks.ESTIMATE, size=14, weight=600) + 12
    x = marks.draw_text(cell, (x, 20), f"frame {instant.frame.truth.frame}", _INK, size=14, weight=600) + 12
    marks.draw_text(cell, (x, 20), describe_state(instant), _INK, size=14)
    return cell
