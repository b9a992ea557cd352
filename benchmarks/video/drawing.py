"""How a scenario's instants are shown: which picture, which words, which shades of the time line."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.suites.registry import suites
from benchmarks.video import legend, marks
from benchmarks.video.instant import Instant, describe_state, draw_instant
from benchmarks.video.legend import Sign
from scenarios.scenario import Episode

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
        uses_larger_view: whether it shows what lies around the observed frame.
        signs: what its pictures and time line hold, for the legend.
    """

    uses_larger_view: bool
    signs: tuple[Sign, ...]

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) of an instant; of one size for all."""
        ...

    def describe(self, instant: Instant) -> str:
        """Return what is so on it, in a few words."""
        ...

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """Return its colours on the time line, bands of equal height from the top; as many for all."""
        ...


class InLargerView:
    """Shows the observed frame in the middle of a larger view, as in the papers: where is what has left it?"""

    uses_larger_view = True
    signs: tuple[Sign, ...] = (
        legend.outlined("observed", marks.OBSERVED),
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


def drawing_of(scenario: str, episode: Episode) -> Drawing:
    """Return what draws an episode of a scenario: what the scene of a suite has for it, else the larger view."""
    of_suites = (each.scene(scenario).drawing for each in suites().values())
    make = next((drawing for drawing in of_suites if drawing is not None), None)
    return InLargerView() if make is None else make(episode)
