"""The fish's tracks as the common detector measures them: input of all gap methods, the same for each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.fish.gap_protocol import Tracks
from benchmarks.judges.runs import runs
from scenarios.fish_tank.truth import FishTruth
from trackers.fish_chain.detection import Detection, Detector, DetectorParameters
from trackers.types import Observation


class Measurement:
    """Detects the fish of each picture, and gives each detection that is beyond doubt to its true fish.

    That is: the fish stands apart and lies whole in the picture, it and the detection are each other's nearest and less
    than half a body apart, and no other fish has its middle in the detection's box. All else is not measured.
    """

    def __init__(self, background: Sequence[Observation], interval_s: float) -> None:
        """``background``: pictures without fish. ``interval_s``: time between frames."""
        self._detector = Detector(DetectorParameters())
        self._detector.start(background)
        self._interval_s = interval_s
        self._frames: list[dict[int, Detection]] = []
        self._true_px: list[NDArray[np.float64]] = []

    def see(self, observation: Observation, truth: FishTruth, apart: NDArray[np.bool_]) -> None:
        """Take the next frame; ``apart``: (N,) which fish stand apart in it."""
        self._true_px.append(truth.position_px)
        self._frames.append(_of_fish(self._detector.detect(observation), truth, apart))

    def tracks(self) -> Tracks:
        """Return the tracks of all frames so far, with the true positions."""
        true_px = np.array(self._true_px)
        points = next((len(each.centre_line_px) for frame in self._frames for each in frame.values()), 1)
        position_px, line_px = np.full_like(true_px, np.nan), np.full((*true_px.shape[:2], points, 2), np.nan)
        for k, frame in enumerate(self._frames):
            for fish, each in frame.items():
                position_px[k, fish], line_px[k, fish] = each.position_px, each.centre_line_px
        for fish in range(true_px.shape[1]):
            line_px[:, fish] = head_first(line_px[:, fish])
        ahead_px = line_px[:, :, 0] - position_px
        heading_rad = np.arctan2(ahead_px[..., 1], ahead_px[..., 0])
        return Tracks(position_px, self._interval_s, heading_rad, line_px, true_px)


def body_length_px(truth: FishTruth) -> NDArray[np.float64]:
    """Return the length (N,) of each fish's centre line in the picture."""
    return np.asarray(np.linalg.norm(np.diff(truth.centre_line_px, axis=1), axis=2).sum(axis=1))


def head_first(line_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centre lines (T, K, 2) of one fish with the head where the detector has seen it most often so far.

    In a run of measured frames a line that lies closer to the one before when it is turned round is turned round. Which
    end is the head is decided for each frame by those up to it, so that no past depends on what a gap hides.
    """
    turned = line_px.copy()
    for first, end in runs(np.asarray(np.isfinite(line_px).all(axis=(1, 2)))):
        flips = np.zeros(end - first, dtype=bool)
        for k in range(first + 1, end):
            both = np.stack([line_px[k], line_px[k, ::-1]])
            as_it_is, reversed_px = np.linalg.norm(turned[k - 1] - both, axis=2).sum(axis=1)
            if reversed_px < as_it_is:
                flips[k - first], turned[k] = True, both[1]
        wrong = first + np.flatnonzero(2 * np.cumsum(flips) > np.arange(1, end - first + 1))
        turned[wrong] = turned[wrong, ::-1]
    return turned


def _of_fish(found: Sequence[Detection], truth: FishTruth, apart: NDArray[np.bool_]) -> dict[int, Detection]:
    """Return the detection of each fish, if it is beyond doubt."""
    if not found:
        return {}
    places = np.array([each.position_px for each in found])
    away_px = np.linalg.norm(truth.position_px[:, None] - places[None], axis=2)
    half_px = 0.5 * body_length_px(truth)
    boxes = np.array([each.box_xyxy for each in found])
    inside = (truth.position_px[:, None] >= boxes[:, :2]) & (truth.position_px[:, None] <= boxes[:, 2:])
    alone = inside.all(axis=2).sum(axis=0) <= 1
    assigned = {}
    for fish in np.flatnonzero(apart & (truth.state == "in")).tolist():
        nearest = int(away_px[fish].argmin())
        mutual = np.nanargmin(away_px[:, nearest]) == fish
        if away_px[fish, nearest] < half_px[fish] and mutual and alone[nearest]:
            assigned[fish] = found[nearest]
    return assigned
