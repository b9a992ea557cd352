"""A contact sheet: the same instants of an episode side by side, a row for each tracker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.writers import marks
from benchmarks.writers.instant import Instant, describe_state, draw_instant

_GAP_PX = 6
_STRIP_PX = 28
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
    height, width = image.shape[:2]
    cell = np.full((_STRIP_PX + height + _GAP_PX, width + _GAP_PX, 3), _GROUND, dtype=np.uint8)
    cell[_STRIP_PX : _STRIP_PX + height, :width] = image
    x = marks.draw_text(cell, (4, 20), tracker, marks.ESTIMATE, size=14, weight=600) + 12
    x = marks.draw_text(cell, (x, 20), f"frame {instant.frame.truth.frame}", _INK, size=14, weight=600) + 12
    marks.draw_text(cell, (x, 20), describe_state(instant), _INK, size=14)
    return cell
