"""A contact sheet: the same instants of an episode side by side, a row for each tracker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.writers import marks
from benchmarks.writers.instant import Instant, describe_state, draw_instant

_GAP_PX = 6
_GROUND = (24, 26, 31)
_INK = (240, 242, 246)


def contact_sheet(rows: Mapping[str, Sequence[Instant]], cell_width_px: int = 600) -> NDArray[np.uint8]:
    """Return the sheet (H, W, 3) uint8.

    Args:
        rows: tracker → instants, as many for each and views of one size.
        cell_width_px: width of one picture.
    """
    drawn = [
        np.concatenate([_cell(tracker, each, cell_width_px) for each in instants], axis=1)
        for tracker, instants in rows.items()
    ]
    sheet = np.concatenate(drawn, axis=0)
    return sheet[:-_GAP_PX, :-_GAP_PX]


def _cell(tracker: str, instant: Instant, width_px: int) -> NDArray[np.uint8]:
    image = draw_instant(instant, zoom=width_px / instant.larger_view_rgb.shape[1])
    frame = f"frame {instant.frame.truth.frame}"
    _label(image, 0, [(tracker, 600)])
    _label(image, image.shape[0] - 26, [(frame, 600), (describe_state(instant), 400)])
    padded = np.full((image.shape[0] + _GAP_PX, image.shape[1] + _GAP_PX, 3), _GROUND, dtype=np.uint8)
    padded[: image.shape[0], : image.shape[1]] = image
    return padded


def _label(image: NDArray[np.uint8], top_px: int, words: Sequence[tuple[str, int]]) -> None:
    """Write words of different weights on a dark patch at the left border."""
    width = sum(marks.text_width_px(text, size=14, weight=weight) + 9 for text, weight in words) + 9
    image[top_px : top_px + 26, :width] = image[top_px : top_px + 26, :width] // 4
    x = 9
    for text, weight in words:
        x = marks.draw_text(image, (x, top_px + 18), text, _INK, size=14, weight=weight) + 9
