"""A tracklet: one fish over frames without a pause, and where it is expected afterwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.bodies import pose_of
from trackers.fish_chain.detection import Detection
from trackers.fish_chain.posture import headings
from trackers.gaps.types import Piece

CHUNK = 8
"""Frames over which a look is averaged; neighbouring frames see the same light and the same beat of the tail."""
_VELOCITY_GAIN = 0.4
_MORE_FEATURES = 4
_LATEST = 40
_MOTION_VOTE = 0.03
"""Way ahead, in lengths of the body, that weighs as much as the balance of one picture."""


class Tracklet:
    """Detections of one fish on successive frames.

    Lines are kept with the same end first on all frames; ``head_first`` says which end the head is.

    Attributes:
        number: its own. first_frame: of its first detection.
        position_px: (2,) on its last frame. velocity_px: (2,) smoothed, pixels a frame.
        ghosts: after its end, poses (4,) by frame while its fish is merged with others (see ``bodies``).
    """

    def __init__(self, number: int, first_frame: int, detection: Detection) -> None:
        self.number = number
        self.first_frame = first_frame
        self.position_px, self.velocity_px = detection.position_px, np.zeros(2)
        self.ghosts: dict[int, NDArray[np.float64]] = {}
        self._lines: list[NDArray[np.float64]] = []
        self._boxes: list[NDArray[np.float64]] = []
        self._rows: list[NDArray[np.float64]] = []
        self._chunks: list[NDArray[np.float64]] = []
        self._areas: list[float] = []
        self._votes = 0.0
        self._widths = np.zeros_like(detection.widths_px)
        self.append(detection)

    @property
    def end_frame(self) -> int:
        """Index of the frame after its last one."""
        return self.first_frame + len(self._lines)

    def __len__(self) -> int:
        return len(self._lines)

    @property
    def head_first(self) -> bool:
        """Whether the first points of its lines are at the head, by the balance of the body and by its motion."""
        return self._votes >= 0

    def append(self, detection: Detection) -> None:
        """Add the detection of the next frame."""
        line, widths, shades, vote = detection.centre_line_px, detection.widths_px, detection.shades, 1.0
        if self._lines:
            last = self._lines[-1]
            moved = detection.position_px - self.position_px
            gain = max(_VELOCITY_GAIN, 1.0 / len(self._lines))
            self.velocity_px = self.velocity_px + gain * (moved - self.velocity_px)
            if ((line[0] - line[-1]) @ (last[0] - last[-1])) < 0:
                line, widths, shades, vote = line[::-1], widths[::-1], shades[::-1], -1.0
            ahead = line[0] - line[-1]
            self._votes += float(moved @ ahead / max(ahead @ ahead, 1.0)) / _MOTION_VOTE
        self._votes += vote
        self.position_px = detection.position_px
        self._lines.append(line)
        self._boxes.append(detection.box_xyxy)
        self._areas.append(detection.area_px)
        self._widths = self._widths + widths
        if not detection.covered:
            self._rows.append(look_of(detection, widths, shades))
        if len(self._rows) == CHUNK:
            self._chunks.append(np.mean(self._rows, axis=0))
            self._rows = []

    @property
    def area_px(self) -> float:
        """Usual area."""
        return float(np.median(self._areas[-_LATEST:]))

    @property
    def halves_px(self) -> NDArray[np.float64]:
        """(K,) usual half width from head to tail."""
        halves = 0.5 * self._widths / len(self)
        return halves if self.head_first else halves[::-1]

    @property
    def length_px(self) -> float:
        """Usual length."""
        lines = np.array(self._lines[-_LATEST:])
        return float(np.median(np.linalg.norm(np.diff(lines, axis=1), axis=2).sum(axis=1)))

    def lines_px(self) -> NDArray[np.float64]:
        """Return the centre lines (T, K, 2) from head to tail."""
        lines = np.array(self._lines)
        return lines if self.head_first else lines[:, ::-1]

    def line_px(self, frame: int) -> NDArray[np.float64]:
        """Return the centre line (K, 2) on one of its frames, from head to tail."""
        line = self._lines[frame - self.first_frame]
        return line if self.head_first else line[::-1]

    def box_xyxy(self, frame: int) -> NDArray[np.float64]:
        """Return the box (4,) on one of its frames."""
        return self._boxes[frame - self.first_frame]

    def looks(self) -> NDArray[np.float64]:
        """Return descriptors (C, D) of successive chunks of the frames on which the fish is seen whole.

        One of all those frames if they are less than a chunk; none if there are none.
        """
        if not self._chunks and not self._rows:
            return np.zeros((0, 2 * len(self._widths) + _MORE_FEATURES))
        chunks = np.array(self._chunks if self._chunks else [np.mean(self._rows, axis=0)])
        return chunks if self.head_first else turned(chunks, len(self._widths))

    def piece(self, interval_s: float, part: slice = slice(None)) -> Piece:
        """Return the tracklet, or a part of its frames, as a piece of track."""
        skipped, _, _ = part.indices(len(self))
        lines = np.array(self._lines[part])
        lines = lines if self.head_first else lines[:, ::-1]
        return Piece(self.first_frame + skipped, lines[:, lines.shape[1] // 2], interval_s, headings(lines), lines)

    def expected_pose(self) -> NDArray[np.float64]:
        """Return the pose (4,) expected on the next frame: that of the last frame, moved on."""
        if self.ghosts:
            pose = self.ghosts[max(self.ghosts)].copy()
        else:
            line = self._lines[-1]
            pose = pose_of(line if self.head_first else line[::-1])
        pose[:2] += self.velocity_px
        return pose

    def place_on(self, frame: int) -> NDArray[np.float64]:
        """Return the place (2,) expected on a frame after its end at constant velocity, from where it was last."""
        last = max(self.ghosts) if self.ghosts else self.end_frame - 1
        place = self.ghosts[last][:2] if self.ghosts else self.position_px
        return place + (frame - last) * self.velocity_px

    def haunt(self, frame: int, pose: NDArray[np.float64]) -> None:
        """Set where its fish is on a frame after its end, found inside a blob of several fish."""
        before = self.ghosts[max(self.ghosts)][:2] if self.ghosts else self.position_px
        self.velocity_px = self.velocity_px + _VELOCITY_GAIN * (pose[:2] - before - self.velocity_px)
        self.ghosts[frame] = pose


def look_of(detection: Detection, widths: NDArray[np.float64], shades: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the descriptor (2 K + 4): shades and widths along the body, logarithms of length and area, colour."""
    sizes = np.log([max(detection.length_px, 1.0), detection.area_px])
    return np.concatenate([shades, widths, sizes, detection.colour])


def turned(looks: NDArray[np.float64], stations: int) -> NDArray[np.float64]:
    """Return descriptors with head and tail exchanged."""
    return np.concatenate(
        [looks[:, :stations][:, ::-1], looks[:, stations : 2 * stations][:, ::-1], looks[:, 2 * stations :]], axis=1
    )
