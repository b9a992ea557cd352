"""One fish: tracklets that were linked, and what is answered of it on every frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.linking import MotionModel
from trackers.fish_chain.posture import STATIONS, body_line
from trackers.fish_chain.tracklets import Tracklet
from trackers.types import Estimate, Track


@dataclass
class Fish:
    """Linked tracklets, in order of time.

    Attributes:
        pieces: at least one. probabilities: that each belongs to the one before; 1 for the first.
    """

    pieces: list[Tracklet]
    probabilities: list[float] = field(default_factory=lambda: [1.0])

    @property
    def identity(self) -> int:
        """Number that no other fish has: that of its first tracklet."""
        return self.pieces[0].number

    @property
    def tail(self) -> Tracklet:
        """Its last tracklet."""
        return self.pieces[-1]

    def __len__(self) -> int:
        return sum(len(each) for each in self.pieces)

    def looks(self) -> NDArray[np.float64]:
        """Return the descriptors (C, D) of all its tracklets."""
        return np.concatenate([each.looks() for each in self.pieces])

    def join(self, other: Fish, probability: float) -> None:
        """Append another fish that continues this one."""
        self.pieces += other.pieces
        self.probabilities += [probability, *other.probabilities[1:]]

    def on(
        self, frame: int, motion: MotionModel, least_certainty: float, next_: tuple[Tracklet, float] | None = None
    ) -> Track | None:
        """Return its track on a frame: measured, followed inside a blob, or between two tracklets.

        None before its first frame, and where it is not known well enough.

        Args:
            least_certainty: see ``ChainParameters``.
            next_: the tracklet that likely continues the last one, and the probability.
        """
        index = sum(each.first_frame <= frame for each in self.pieces) - 1
        if index < 0:
            return None
        piece, probability = self.pieces[index], self.probabilities[index]
        if frame < piece.end_frame:
            return measured(self.identity, piece.line_px(frame), piece.box_xyxy(frame), probability)
        if index + 1 < len(self.pieces):
            next_ = self.pieces[index + 1], self.probabilities[index + 1]
        if next_ is not None:
            probability = next_[1]
        lost = frame - piece.end_frame
        if frame in piece.ghosts:
            place, covariance = piece.ghosts[frame][:2], motion.followed(lost)
        elif next_ is not None:
            places, covariances = motion.between(piece, next_[0])
            place, covariance = places[lost], covariances[lost]
        else:
            return None
        track = predicted(self.identity, piece, frame, place, covariance, probability, motion.length_px)
        certain = track.confidence is not None and track.confidence >= least_certainty * probability
        return track if certain else None


def measured(identity: int, line_px: NDArray[np.float64], box_xyxy: NDArray[np.float64], probability: float) -> Track:
    """Return the track of a fish that was detected with a centre line (K, 2)."""
    middle = line_px[len(line_px) // 2]
    estimate = Estimate(middle, box_xyxy, heading_rad=_heading(line_px), centre_line_px=line_px)
    return Track(identity, estimate, kind="fish", confidence=probability)


def predicted(
    identity: int,
    tail: Tracklet,
    frame: int,
    place_px: NDArray[np.float64],
    covariance_px: NDArray[np.float64],
    probability: float,
    length_px: float,
) -> Track:
    """Return the track of a fish that was not detected; it is less certain, the wider its place is known.

    The confidence is the link's probability times that of a place within half a length of the body.
    """
    variance = 0.5 * float(np.trace(covariance_px))
    within = 1.0 - math.exp(-((0.5 * length_px) ** 2) / (2 * variance))
    pose = tail.ghosts.get(frame)
    line = None if pose is None else body_line(pose, tail.length_px, STATIONS)
    last_xyxy = tail.box_xyxy(tail.end_frame - 1)
    half = 0.5 * (last_xyxy[2:] - last_xyxy[:2])
    if line is not None:
        half = 0.5 * np.ptp(line, axis=0) + tail.halves_px.max()
        place_px = 0.5 * (line.min(axis=0) + line.max(axis=0))
    estimate = Estimate(
        place_px if line is None else line[STATIONS // 2],
        np.concatenate([place_px - half, place_px + half]),
        heading_rad=None if line is None else _heading(line),
        covariance_px=covariance_px,
        centre_line_px=line,
    )
    return Track(identity, estimate, kind="fish", confidence=probability * within)


def _heading(line_px: NDArray[np.float64]) -> float:
    ahead = line_px[0] - line_px[len(line_px) // 2]
    return math.atan2(ahead[1], ahead[0])
