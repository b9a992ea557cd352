"""Drawings of a scenario's instants: picture, description and shades of the time line."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.show.video import legend, marks
from benchmarks.show.video.instant import Instant, describe_state, draw_instant
from benchmarks.show.video.legend import Sign

_SHADE: dict[str, marks.Rgb] = {
    "in": (54, 58, 66),
    "partial": (120, 84, 104),
    "occluded": (96, 96, 96),
    "out": (204, 121, 167),
    "absent": (30, 32, 36),
}


class Drawing(Protocol):
    """Draws the instants of one episode.

    Attributes:
        uses_larger_view: whether it shows the surroundings of the observed frame.
        signs: entries of the legend.
    """

    uses_larger_view: bool
    signs: tuple[Sign, ...]

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) of an instant; all have one size."""
        ...

    def describe(self, instant: Instant) -> str:
        """Return its description in a few words."""
        ...

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """Return its colours on the time line, bands of equal height from the top; equally many for all instants."""
        ...


class InLargerView:
    """Shows the observed frame in the middle of a larger view, as in the papers, so that a target outside is seen."""

    uses_larger_view = True
    signs: tuple[Sign, ...] = (
        legend.outlined("the camera's picture", marks.OBSERVED),
        legend.TRUTH,
        legend.shaded("out of view", _SHADE["out"]),
        legend.ESTIMATE,
        legend.POSTERIOR,
        legend.PROBABILITY,
    )

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        return draw_instant(instant)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        return describe_state(instant)

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        if len(instant.targets) != 1:
            return (_SHADE["in"],)
        return (_SHADE[str(instant.frame.judged[0].state[instant.target])],)
