"""``ca_kalman``: the gap method of paper C, and tracklets that it gives their successors as the paper has it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trackers.fish_chain.detection import Detector, DetectorParameters
from trackers.fish_chain.fish import Fish, measured
from trackers.fish_chain.tracklets import Tracklet, TrackletBuilder, TrackletParameters
from trackers.gap_kalman.ca_kalman import CaKalman, CaKalmanParameters, successor_distances
from trackers.gaps import Surroundings
from trackers.registry import register
from trackers.types import CameraModel, Observation, Track

_SEARCH_FRAMES = 200
_LEAST_FRAMES = 5
"""A successor begins within so many frames, and lasts as long at least."""


@register(
    "ca_kalman",
    role="as-written",
    summary="constant-acceleration Kalman filter of paper C; a tracklet goes on in the one nearest to its prediction",
    suites=("fish",),
)
class CaKalmanTracker:
    """Names the tracklets of ``fish_chain`` as the paper does.

    Reading: tracklets get their successors in the order of their ends, each start once. Nothing is answered in gaps,
    nor names at once: until the last picture every tracklet has a name of its own.

    Source: paper C, see ``trackers.papers``.
    """

    Parameters = CaKalmanParameters

    def __init__(self, parameters: CaKalmanParameters, rng: np.random.Generator) -> None:
        self.gap_method = CaKalman(parameters)
        self._begin(())

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._begin(background)

    def _begin(self, background: Sequence[Observation]) -> None:
        self._detector = Detector(DetectorParameters())
        self._detector.start(background)
        self._builder = TrackletBuilder(TrackletParameters(use_posture=False))
        self._times_s: list[float] = []

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        frame = len(self._times_s)
        self._times_s.append(observation.time_s)
        detections = self._detector.detect(observation)
        self._builder.step(frame, detections, self._detector.body_px)
        return [measured(each.number, each.line_px(frame), each.box_xyxy(frame), 1.0) for each in self._builder.active]

    def revised(self) -> list[list[Track]]:
        """See ``RevisingTracker``."""
        tracklets = sorted([*self._builder.ended, *self._builder.active], key=lambda each: each.end_frame)
        fish = {each.number: Fish([each]) for each in tracklets}
        heads = {each.number for each in tracklets}
        for tail in tracklets:
            free = [each for each in tracklets if each.number in heads and self._may_follow(tail, each)]
            if free:
                nearest = free[self._nearest(tail, free)]
                heads.remove(nearest.number)
                fish[nearest.number] = fish[tail.number]
                fish[tail.number].join(Fish([nearest]), 1.0)
        answers: list[list[Track]] = [[] for _ in self._times_s]
        for tracklet in tracklets:
            for frame in range(tracklet.first_frame, tracklet.end_frame):
                name, line, box = fish[tracklet.number].identity, tracklet.line_px(frame), tracklet.box_xyxy(frame)
                answers[frame].append(measured(name, line, box, 1.0))
        return answers

    def _may_follow(self, tail: Tracklet, start: Tracklet) -> bool:
        return 0 <= start.first_frame - tail.end_frame <= _SEARCH_FRAMES and len(start) >= _LEAST_FRAMES

    def _nearest(self, tail: Tracklet, starts: Sequence[Tracklet]) -> int:
        steps_s = np.diff(self._times_s)
        interval_s = max(float(np.median(steps_s)), 1e-3) if len(steps_s) else 1.0
        pieces = [each.piece(interval_s) for each in starts]
        return int(np.argmin(successor_distances(self.gap_method, tail.piece(interval_s), pieces, Surroundings())))
