"""The reference of the suite ``many`` that sees no picture: what boxes at rest are worth.

Blind trackers of single scenes, such as ``harbour_posts``, answer with places where targets often are; this one answers
with the true boxes at the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.judges.many.judge import objects_of
from scenarios.loop import LoopTracker
from scenarios.scenario import Episode, Frame
from trackers.registry import NoParameters
from trackers.types import Estimate, Start, Track


class FirstBoxes:
    """Answers on every frame with the true boxes of the targets in the first picture, each under one identity."""

    def initialise(self, frame: Frame, start: Start) -> Sequence[Track]:
        """See ``scenarios.loop.LoopTracker``."""
        objects = objects_of(frame.truth)
        targets = zip(objects.number[objects.is_target], objects.box_xyxy[objects.is_target], strict=True)
        self._tracks = tuple(
            Track(int(identity), Estimate(0.5 * (box[:2] + box[2:]), box_xyxy=box.copy())) for identity, box in targets
        )
        return self._tracks

    def update(self, frame: Frame) -> Sequence[Track]:
        """See ``scenarios.loop.LoopTracker``."""
        return self._tracks


@dataclass(frozen=True, kw_only=True)
class BoxesAtRest(TrackerSpec):
    """Makes ``FirstBoxes``."""

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        return FirstBoxes()


FIRST_BOXES = BoxesAtRest(
    name="first_boxes",
    role="blind",
    summary="the true boxes of the first picture, at rest from then on",
    suites=("many",),
    parameters=NoParameters(),
    module=FirstBoxes.__module__,
)
