"""Reduction of a tracker of many targets to one target, for suites of one target and for envs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackers.estimate_check import check_tracks
from trackers.protocols import MultiTracker
from trackers.types import Estimate, Observation, Track


class FollowOne:
    """A ``Tracker`` that returns one track of a ``MultiTracker``.

    It is the track nearest to the centre of the target's first box, and inside it, on the first picture with such a
    track. Its identity is followed from then on; on pictures without it the estimate is NaN.
    """

    def __init__(self, tracker: MultiTracker, background: Sequence[Observation] = ()) -> None:
        """``background``: pictures without targets, see ``MultiTracker.start``."""
        self._tracker = tracker
        self._background = tuple(background)
        self._box_xyxy = np.zeros(4)
        self._identity: int | None = None

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        self._box_xyxy = np.asarray(box_xyxy, dtype=float)
        self._tracker.start(self._background, observation.camera)
        self.update(observation)

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        tracks = self._tracker.update(observation)
        check_tracks(tracks)
        if self._identity is None:
            self._identity = self._identity_in_box(tracks)
        found = (track.estimate for track in tracks if track.identity == self._identity)
        return next(found, Estimate(position_px=np.full(2, np.nan)))

    def _identity_in_box(self, tracks: Sequence[Track]) -> int | None:
        low, high = self._box_xyxy[:2], self._box_xyxy[2:]
        offsets_px = {
            track.identity: float(np.hypot(*(track.estimate.position_px - 0.5 * (low + high))))
            for track in tracks
            if ((low <= track.estimate.position_px) & (track.estimate.position_px <= high)).all()
        }
        return min(offsets_px, key=lambda identity: offsets_px[identity], default=None)
