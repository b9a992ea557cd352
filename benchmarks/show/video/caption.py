"""The strip under a video: episode, frame, the target's state, and the tracker's probability of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Drawing
from benchmarks.show.video.instant import Instant
from benchmarks.show.video.legend import draw_legend, outlined

HEIGHT_PX = 116
_GROUND = (24, 26, 31)
_INK = (236, 238, 242)
_QUIET = (150, 156, 166)
_TRACK_TOP, _TRACK_BOTTOM = 78, 106
_STEERED = outlined("2nd camera", marks.OBSERVED)


class Caption:
    """Draws the strip frame by frame, with a time line of all frames so far."""

    def __init__(self, drawing: Drawing, title: str, frame_count: int, width_px: int) -> None:
        self._drawing = drawing
        self._title = title
        self._frame_count = frame_count
        self._width = width_px
        self._shades: list[tuple[marks.Rgb, ...]] = []
        self._probabilities: list[float] = []

    def draw(self, instant: Instant) -> NDArray[np.uint8]:
        """Return the strip (HEIGHT_PX, width, 3) of the next instant."""
        truth, estimate = instant.frame.truth, instant.estimate
        probability = None if estimate is None else estimate.in_view_probability
        self._shades.append(self._drawing.shades(instant))
        self._probabilities.append(np.nan if probability is None else probability)
        strip = np.full((HEIGHT_PX, self._width, 3), _GROUND, dtype=np.uint8)
        marks.draw_text(strip, (16, 28), f"frame {truth.frame}", _INK, size=19, weight=600)
        marks.draw_text(strip, (130, 28), f"{truth.time_s:.1f} s", _QUIET, size=16)
        end = marks.draw_text(strip, (200, 28), self._drawing.describe(instant), _INK, size=16)
        if estimate is not None and np.isnan(estimate.position_px).any():
            marks.draw_text(strip, (end + 28, 28), "tracker: no answer", marks.ESTIMATE, size=16)
        elif probability is not None:
            marks.draw_text(strip, (end + 28, 28), f"tracker: {probability:.0%} in view", marks.ESTIMATE, size=16)
        width = marks.text_width_px(self._title, size=14)
        marks.draw_text(strip, (self._width - 16 - width, 27), self._title, _QUIET, size=14)
        signs = self._drawing.signs if instant.frame.steered is None else (*self._drawing.signs, _STEERED)
        draw_legend(strip, (16, 58), signs, with_tracker=instant.answer is not None)
        self._draw_time_line(strip)
        return strip

    def _draw_time_line(self, strip: NDArray[np.uint8]) -> None:
        left, right = 16, self._width - 16
        edges = np.linspace(left, right, self._frame_count + 1)
        strip[_TRACK_TOP:_TRACK_BOTTOM, left:right] = (36, 39, 45)
        for k, shades in enumerate(self._shades):
            rows = np.linspace(_TRACK_TOP, _TRACK_BOTTOM, len(shades) + 1).round().astype(int)
            for top, bottom, shade in zip(rows[:-1], rows[1:], shades, strict=True):
                strip[top:bottom, round(edges[k]) : round(edges[k + 1])] = shade
        known = np.flatnonzero(np.isfinite(self._probabilities))
        if len(known) > 1:
            share = np.array(self._probabilities)[known]
            y = _TRACK_BOTTOM - 3 - share * (_TRACK_BOTTOM - _TRACK_TOP - 6)
            x = 0.5 * (edges[known] + edges[known + 1])
            marks.draw_lines(strip, [np.stack([x, y], axis=1)], marks.ESTIMATE)
        now = edges[len(self._shades)]
        marks.draw_lines(strip, [[(now, _TRACK_TOP - 4.0), (now, _TRACK_BOTTOM + 4.0)]], _INK, 1)
