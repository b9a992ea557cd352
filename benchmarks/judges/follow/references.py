"""The reference of the suite ``follow``, with unfair knowledge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from scenarios.loop import LoopTracker, given
from scenarios.scenario import Episode, Frame
from trackers.registry import NoParameters
from trackers.types import Estimate, Start

_CERTAIN_PX = 1e-3
"""Standard deviation of the answered position."""


class TrueTarget:
    """Answers with the target's true position on every frame, also outside the picture.

    A controller that steers by it misses the target only as far as the carrier's limits, the gusts and the controller
    itself are to blame. The tracker's share is what is missing to it with a tracker in its place.
    """

    def __init__(self, target: str) -> None:
        self._target = target

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``scenarios.loop.Tracker``."""
        return given(start) if start.box_xyxy is not None else self.update(frame)

    def update(self, frame: Frame) -> Estimate:
        """See ``scenarios.loop.Tracker``.

        The distance along the axis is answered too, as some carriers steer by it: that of the point whose pixel
        ``position_px`` is. There is none of a target behind the camera or outside the world, and no box of one that
        is partly behind the camera.
        """
        truth = frame.truth
        target = truth.index_of(self._target)
        pose, position_px = truth.T_world_object[target], truth.position_px[target].copy()
        box_xyxy = truth.box_xyxy[target].copy()
        middle_m = pose[:3, 3] + 0.5 * truth.size_m[target, 2] * pose[:3, 2]
        depth_m = float((middle_m - truth.T_world_camera[:3, 3]) @ truth.T_world_camera[:3, 2])
        return Estimate(
            position_px,
            box_xyxy if np.isfinite(box_xyxy).all() else None,
            in_view_probability=float(truth.state[target] in ("in", "partial")),
            covariance_px=_CERTAIN_PX**2 * np.eye(2),
            depth_m=depth_m if np.isfinite(position_px).all() else None,
        )


@dataclass(frozen=True, kw_only=True)
class TruthOracle(TrackerSpec):
    """Answers with the truth, see ``TrueTarget``."""

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        assert named.scenario is not None
        return TrueTarget(named.scenario.target)


ORACLE = TruthOracle(
    name="oracle_target",
    role="oracle",
    summary="the target's true position on every picture: what a controller could do with a perfect tracker",
    suites=("follow",),
    parameters=NoParameters(),
    module=TrueTarget.__module__,
)
