"""Trackers without pictures: they receive one target's true state at each exit, or gaps to bridge, or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scenarios.loop import ManyFromPictures, first_box, given
from scenarios.scenario import Frame
from scenarios.truth import Truth
from trackers.protocols import BlindTracker, TargetState, Tracker
from trackers.types import Estimate, Observation, Start, Track

BLIND_NOTE = (
    "Blind trackers get no picture. They get the target's true state at the start and at each exit, "
    "and no signal of its return; the blind controller commands nothing. A method's lead over them is what its "
    "pictures are shown to be worth."
)
"""Note under tables with the role ``blind``."""

_NO_PICTURE = np.empty((0, 0, 3), np.uint8)


class Blindfolded:
    """See ``trackers.Tracker``. Pictures and camera settings are removed from observations.

    The state at an exit is that of the first frame outside, as for ``oracle_map``.
    """

    def __init__(self, tracker: Tracker, target: str) -> None:
        """``target``: name of the object whose state is given. Raises TypeError for a tracker that does not take it."""
        if not isinstance(tracker, BlindTracker):
            raise TypeError(f"tracker: expected one with a method set_state, since its role is blind, got {tracker!r}")
        self._tracker, self._target = tracker, target

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``LoopTracker``."""
        observation = _unseen(frame.observation)
        self._tracker.initialise(observation, first_box(start))
        self._tracker.set_state(observation, _state_of(frame.truth, frame.truth.index_of(self._target)))
        return given(start)

    def update(self, frame: Frame) -> Estimate:
        """See ``LoopTracker``."""
        observation = _unseen(frame.observation)
        target = frame.truth.index_of(self._target)
        if frame.truth.frames_since_exit[target] == 0:
            self._tracker.set_state(observation, _state_of(frame.truth, target))
        return self._tracker.update(observation)


class ManyBlindfolded(ManyFromPictures):
    """See ``loop.ManyTracker``. Pictures and camera settings are removed from observations, the background too."""

    def initialise(self, frame: Frame, start: Start) -> Sequence[Track]:
        """See ``LoopTracker``."""
        return super().initialise(frame, replace(start, background=()))

    def update(self, frame: Frame) -> Sequence[Track]:
        """See ``LoopTracker``."""
        return super().update(replace(frame, observation=_unseen(frame.observation)))


def _unseen(observation: Observation) -> Observation:
    return replace(observation, image_rgb=_NO_PICTURE, right_rgb=None, counts=None, settings=None)


def _state_of(truth: Truth, target: int) -> TargetState:
    R_camera_world = truth.T_world_camera[:3, :3].T
    pose = truth.T_world_object[target]
    centre_m = pose[:3, 3] + 0.5 * truth.size_m[target, 2] * pose[:3, 2]
    return TargetState(
        place_m=R_camera_world @ (centre_m - truth.T_world_camera[:3, 3]),
        velocity_mps=R_camera_world @ (truth.speed_mps[target] * pose[:3, 0]),
    )
