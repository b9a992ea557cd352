"""Videos of a tank: true centre lines, every track in the colour of its identity with its trail, and bridged gaps."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Canvas, Drawing, Instant, draw_mask, draw_name, draw_posterior, draw_steered
from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import Episode

_WIDTH_PX = 960
_TRAIL_FRAMES = 45
_NAMED_AT_MOST = 30
"""Names of more tracks than this would hide the picture."""
_CROSSING = (130, 84, 118)


class FishDrawing(Drawing):
    """See ``Drawing``."""

    signs: Mapping[str, marks.Rgb] = {"true centre line": marks.TRUTH, "a fish hides another": _CROSSING}
    answers: Mapping[str, marks.Rgb] = {"tracks, a colour for each identity; 95 % regions": marks.colour_of(0)}

    def __init__(self, episode: Episode) -> None:
        self._trails: deque[dict[int, NDArray[np.float64]]] = deque(maxlen=_TRAIL_FRAMES)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        canvas = Canvas.of(instant.frame.observation.image_rgb, _WIDTH_PX)
        truth = truth_as(instant.frame.truth, FishTruth)
        lines = marks.fixed_point(canvas.at(truth.centre_line_px[list(instant.targets)]))
        cv2.polylines(canvas.image, list(lines), False, marks.TRUTH, 1, cv2.LINE_AA, 4)
        draw_steered(canvas, instant.frame)
        estimates = {int(name or 0): each for name, each in instant.estimates if np.isfinite(each.position_px).all()}
        self._trails.append({name: canvas.at(each.position_px) for name, each in estimates.items()})
        for name, estimate in estimates.items():
            colour = marks.colour_of(name)
            trail = marks.fixed_point([places[name] for places in self._trails if name in places])
            cv2.polylines(canvas.image, [trail], False, colour, 1, cv2.LINE_AA, 4)
            if estimate.mask is not None:
                draw_mask(canvas, estimate.mask, colour)
            if estimate.centre_line_px is not None and np.isfinite(estimate.centre_line_px).all():
                marks.draw_lines(canvas.image, [canvas.at(estimate.centre_line_px)], colour)
            else:
                draw_posterior(canvas, estimate, colour)
            if len(estimates) <= _NAMED_AT_MOST:
                draw_name(canvas, canvas.at(estimate.position_px), str(name), colour)
        return canvas.image

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        return f"{self._hidden(instant) or 'no'} fish behind another"

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        return (_CROSSING if self._hidden(instant) else marks.CALM,)

    def _hidden(self, instant: Instant) -> int:
        truth = truth_as(instant.frame.truth, FishTruth)
        return int((truth.hidden_by[list(instant.targets)] >= 0).sum())
