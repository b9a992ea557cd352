"""Videos of a tank: true centre lines, every track in the colour of its identity with its trail, and bridged gaps."""

from __future__ import annotations

import colorsys
from collections import deque

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Instant, Sign, draw_steered, shaded
from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import Episode
from trackers.types import Estimate

_WIDTH_PX = 960
_TRAIL_FRAMES = 45
_NAMED_AT_MOST = 30
"""Names of more tracks than this would hide the picture."""
_GOLDEN_TURN = 0.618034
_CALM, _CROSSING = (54, 58, 66), (130, 84, 118)


def colour_of(identity: int) -> marks.Rgb:
    """Return the colour of an identity; those of neighbouring numbers differ most."""
    red, green, blue = colorsys.hls_to_rgb((identity * _GOLDEN_TURN) % 1.0, 0.6, 0.95)
    return int(255 * red), int(255 * green), int(255 * blue)


def _draw_true_line(image: marks.Image, x: int, y: int) -> None:
    marks.draw_lines(image, [[(x, y - 3.0), (x + 7, y - 7.0), (x + 13, y - 3.0), (x + 20, y - 7.0)]], marks.TRUTH, 1)


def _draw_trail(image: marks.Image, x: int, y: int) -> None:
    for k in range(3):
        marks.draw_lines(image, [[(x, y - 10.0 + 5 * k), (x + 20, y - 10.0 + 5 * k)]], colour_of(k), 1)


def _draw_bridged(image: marks.Image, x: int, y: int) -> None:
    marks.draw_ellipse(image, np.array([x + 10.0, y - 5.0]), np.diag([12.0, 5.0]), colour_of(0))


class FishDrawing:
    """See ``Drawing``."""

    uses_larger_view = False
    signs: tuple[Sign, ...] = (
        Sign("true centre line", _draw_true_line),
        shaded("a fish hides another", _CROSSING),
        Sign("tracks, a colour for each identity", _draw_trail, of_tracker=True),
        Sign("predicted, with its 95 % region", _draw_bridged, of_tracker=True),
    )

    def __init__(self, episode: Episode) -> None:
        self._trails: deque[dict[int, NDArray[np.float64]]] = deque(maxlen=_TRAIL_FRAMES)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``. Instants come in order, as trails grow with them."""
        observed = instant.frame.observation.image_rgb
        zoom = _WIDTH_PX / observed.shape[1]
        image = np.asarray(cv2.resize(observed, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_CUBIC), np.uint8)
        truth = truth_as(instant.frame.truth, FishTruth)
        for line_px in truth.centre_line_px[list(instant.targets)]:
            cv2.polylines(image, [marks.fixed_point(line_px * zoom)], False, marks.TRUTH, 1, cv2.LINE_AA, 4)
        draw_steered(image, instant.frame, zoom)
        estimates = {int(name or 0): estimate for name, estimate in instant.estimates}
        known = {name: each for name, each in estimates.items() if np.isfinite(each.position_px).all()}
        self._trails.append({name: each.position_px * zoom for name, each in known.items()})
        for name, estimate in known.items():
            self._draw_track(image, name, estimate, zoom, is_named=len(known) <= _NAMED_AT_MOST)
        return image

    def _draw_track(self, image: marks.Image, name: int, estimate: Estimate, zoom: float, *, is_named: bool) -> None:
        colour, place = colour_of(name), estimate.position_px * zoom
        trail = [places[name] for places in self._trails if name in places]
        cv2.polylines(image, [marks.fixed_point(trail)], False, colour, 1, cv2.LINE_AA, 4)
        if estimate.centre_line_px is not None and np.isfinite(estimate.centre_line_px).all():
            marks.draw_lines(image, [estimate.centre_line_px * zoom], colour)
        elif estimate.covariance_px is not None and np.isfinite(estimate.covariance_px).all():
            marks.draw_ellipse(image, place, estimate.covariance_px * zoom**2, colour)
        if is_named:
            x, y = (place + 8.0 * np.array([1.0, -1.0])).astype(int)
            marks.draw_label(image, (x, y), str(name), colour, size=17, weight=600)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        hidden = self._hidden(instant)
        return "no fish hides another" if hidden == 0 else f"{hidden} fish behind another"

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        return (_CROSSING if self._hidden(instant) else _CALM,)

    def _hidden(self, instant: Instant) -> int:
        truth = truth_as(instant.frame.truth, FishTruth)
        return int((truth.hidden_by[list(instant.targets)] >= 0).sum())
