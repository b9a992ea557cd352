"""Videos of a person followed by a stereo camera: four pictures, with occluders and changes of light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.judges.stereo.metrics.people import SEEN_AT_LEAST
from benchmarks.show.stereo.instant import draw_stereo_instant
from benchmarks.show.video import legend, marks
from benchmarks.show.video.instant import Instant
from benchmarks.show.video.legend import Sign
from scenarios.scenario import Episode
from scenarios.stereo_follow.floor_plan import RoomPlan
from scenarios.stereo_follow.truth import PeopleTruth, StereoTruth
from trackers.light_adaptive_stereo.matching import StereoMatcher

_CALM, _HIDDEN, _NEW_LIGHT = (54, 58, 66), (130, 84, 118), (120, 170, 90)

_WHOLE = 0.9
"""Visible share from which no occluder is named."""


class StereoDrawing:
    """See ``benchmarks.show.video.drawing.Drawing``."""

    uses_larger_view = False
    signs: tuple[Sign, ...] = (
        legend.TRUTH,
        legend.shaded("light has changed", _NEW_LIGHT),
        legend.shaded("hidden", _HIDDEN),
        legend.ESTIMATE,
        legend.PROBABILITY,
    )

    def __init__(self, plan: RoomPlan) -> None:
        self._plan = plan
        self._matcher = StereoMatcher()

    @classmethod
    def of(cls, episode: Episode) -> StereoDrawing:
        """Return the drawing of an episode of either scenario of the suite."""
        return cls(episode.map_of().plan)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        return draw_stereo_instant(instant, self._plan, self._matcher)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        return describe_person(instant)

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``: light above, visibility of the target below."""
        truth = truth_as(instant.frame.truth, StereoTruth)
        is_seen = truth.visible_fraction[instant.target] >= SEEN_AT_LEAST
        return (_CALM if truth.light_event is None else _NEW_LIGHT, _CALM if is_seen else _HIDDEN)


def describe_person(instant: Instant) -> str:
    """Return visibility, occluder and change of light in words: ``9 % seen, behind crosser-3, lamp off``."""
    truth = truth_as(instant.frame.truth, StereoTruth)
    if truth.state[instant.target] == "out":
        words = "out of view"
    else:
        seen = truth.visible_fraction[instant.target]
        occluder = truth.occluder[instant.target] if isinstance(truth, PeopleTruth) else -1
        words = f"{seen:.0%} seen"
        words += f", behind {truth.names[occluder]}" if occluder >= 0 and seen < _WHOLE else ""
    return words if truth.light_event is None else f"{words}, {truth.light_event}"
