"""The legend of a caption: signs and their meanings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.show.video import marks

_WIDTH_PX, _RISE_PX, _DROP_PX = 20, 12, 2
"""Width of a sign, and its extent above and below the baseline of the text."""
_QUIET = (150, 156, 166)


@dataclass(frozen=True, slots=True)
class Sign:
    """A sign and its meaning.

    Attributes:
        words: its meaning.
        draw: draws it on a picture with the lower left corner at (x, y) of the baseline.
        of_tracker: whether it is drawn only with a tracker.
    """

    words: str
    draw: Callable[[marks.Image, int, int], None]
    of_tracker: bool = False


def outlined(words: str, colour: marks.Rgb) -> Sign:
    """Return the sign of an outline in a colour."""

    def draw(image: marks.Image, x: int, y: int) -> None:
        marks.draw_box(image, np.array([x, y - _RISE_PX, x + _WIDTH_PX, y + float(_DROP_PX)]), colour)

    return Sign(words, draw)


def shaded(words: str, colour: marks.Rgb) -> Sign:
    """Return the sign of a shade on the time line."""

    def draw(image: marks.Image, x: int, y: int) -> None:
        image[y - _RISE_PX : y + _DROP_PX, x : x + _WIDTH_PX] = colour

    return Sign(words, draw)


def _draw_estimate(image: marks.Image, x: int, y: int) -> None:
    marks.draw_corners(image, np.array([x, y - _RISE_PX, x + _WIDTH_PX, y + float(_DROP_PX)]), marks.ESTIMATE)
    marks.draw_cross(image, np.array([x + 10.0, y - 5.0]), marks.ESTIMATE, stroke_px=1)


def _draw_posterior(image: marks.Image, x: int, y: int) -> None:
    cloud = np.array([[2.0, -3], [7, -8], [9, -1], [13, -6], [18, -4]]) + np.array([x, y])
    marks.draw_particles(image, cloud, None, marks.PARTICLE)


def _draw_probability(image: marks.Image, x: int, y: int) -> None:
    marks.draw_lines(image, [[(x, y - 5.0), (x + _WIDTH_PX, y - 5.0)]], marks.ESTIMATE)


TRUTH = outlined("truth", marks.TRUTH)
ESTIMATE = Sign("estimate", _draw_estimate, of_tracker=True)
POSTERIOR = Sign("particles or 95 % ellipse", _draw_posterior, of_tracker=True)
PROBABILITY = Sign("tracker's probability of being in view", _draw_probability, of_tracker=True)


def draw_legend(image: marks.Image, at_px: tuple[int, int], signs: Sequence[Sign], *, with_tracker: bool) -> None:
    """Draw signs in a row, each before its text; the baseline begins at ``at_px``."""
    x, y = at_px
    for sign in signs:
        if with_tracker or not sign.of_tracker:
            sign.draw(image, x, y)
            x = marks.draw_text(image, (x + 28, y), sign.words, _QUIET, size=14) + 24
