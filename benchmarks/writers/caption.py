"""The strip under a video: which episode and frame, where the target is, what the tracker thinks of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.writers import marks
from benchmarks.writers.instant import Instant, describe_state

HEIGHT_PX = 116
_GROUND = (24, 26, 31)
_INK = (236, 238, 242)
_QUIET = (150, 156, 166)
_STATE_SHADE = {
    "in": (54, 58, 66),
    "partial": (120, 84, 104),
    "occluded": (96, 96, 96),
    "out": (204, 121, 167),
}
_TRACK_TOP, _TRACK_BOTTOM = 78, 106


class Caption:
    """Draws the strip frame by frame, and remembers what went before for its time line."""

    def __init__(self, title: str, frame_count: int, width_px: int) -> None:
        self._title = title
        self._frame_count = frame_count
        self._width = width_px
        self._states: list[str] = []
        self._probabilities: list[float] = []

    def draw(self, instant: Instant) -> NDArray[np.uint8]:
        """Return the strip (HEIGHT_PX, width, 3) of the next instant."""
        truth, estimate = instant.frame.truth, instant.estimate
        said = None if estimate is None else estimate.in_view_probability
        self._states.append(truth.state)
        self._probabilities.append(np.nan if said is None else said)
        strip = np.full((HEIGHT_PX, self._width, 3), _GROUND, dtype=np.uint8)
        marks.draw_text(strip, (16, 28), f"frame {truth.frame}", _INK, size=19, weight=600)
        marks.draw_text(strip, (130, 28), f"{truth.time_s:.1f} s", _QUIET, size=16)
        end = marks.draw_text(strip, (200, 28), describe_state(instant), _INK, size=16)
        if said is not None:
            marks.draw_text(strip, (end + 28, 28), f"tracker: {said:.0%} in view", marks.ESTIMATE, size=16)
        width = marks.text_width_px(self._title, size=14)
        marks.draw_text(strip, (self._width - 16 - width, 27), self._title, _QUIET, size=14)
        self._draw_legend(strip, estimate is not None)
        self._draw_time_line(strip)
        return strip

    def _draw_legend(self, strip: NDArray[np.uint8], with_tracker: bool) -> None:
        x, y = 16, 58
        marks.draw_box(strip, np.array([x, y - 12, x + 20, y + 2.0]), marks.OBSERVED)
        x = marks.draw_text(strip, (x + 28, y), "observed", _QUIET, size=14) + 24
        marks.draw_box(strip, np.array([x, y - 12, x + 20, y + 2.0]), marks.TRUTH)
        x = marks.draw_text(strip, (x + 28, y), "truth", _QUIET, size=14) + 24
        strip[y - 12 : y + 2, x : x + 20] = _STATE_SHADE["out"]
        x = marks.draw_text(strip, (x + 28, y), "out of view", _QUIET, size=14) + 24
        if not with_tracker:
            return
        marks.draw_corners(strip, np.array([x, y - 12, x + 20, y + 2.0]), marks.ESTIMATE)
        marks.draw_cross(strip, np.array([x + 10.0, y - 5.0]), marks.ESTIMATE, stroke_px=1)
        x = marks.draw_text(strip, (x + 28, y), "estimate", _QUIET, size=14) + 24
        cloud = np.array([[2.0, -3], [7, -8], [9, -1], [13, -6], [18, -4]]) + np.array([x, y])
        marks.draw_particles(strip, cloud, None, marks.PARTICLE)
        x = marks.draw_text(strip, (x + 28, y), "particles or 95 % ellipse", _QUIET, size=14) + 24
        marks.draw_lines(strip, [[(x, y - 5.0), (x + 20, y - 5.0)]], marks.ESTIMATE)
        marks.draw_text(strip, (x + 28, y), "tracker's probability of being in view", _QUIET, size=14)

    def _draw_time_line(self, strip: NDArray[np.uint8]) -> None:
        left, right = 16, self._width - 16
        edges = np.linspace(left, right, self._frame_count + 1)
        strip[_TRACK_TOP:_TRACK_BOTTOM, left:right] = (36, 39, 45)
        for k, state in enumerate(self._states):
            strip[_TRACK_TOP:_TRACK_BOTTOM, round(edges[k]) : round(edges[k + 1])] = _STATE_SHADE[state]
        known = np.flatnonzero(np.isfinite(self._probabilities))
        if len(known) > 1:
            share = np.array(self._probabilities)[known]
            y = _TRACK_BOTTOM - 3 - share * (_TRACK_BOTTOM - _TRACK_TOP - 6)
            x = 0.5 * (edges[known] + edges[known + 1])
            marks.draw_lines(strip, [np.stack([x, y], axis=1)], marks.ESTIMATE)
        now = edges[len(self._states)]
        marks.draw_lines(strip, [[(now, _TRACK_TOP - 4.0), (now, _TRACK_BOTTOM + 4.0)]], _INK, 1)
