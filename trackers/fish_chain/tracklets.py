"""Tracklets, one fish each over frames without a pause, made from detections by assignment from frame to frame.

A tracklet ends where fish merge, vanish or could be confused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.fish_chain.detection import Detection
from trackers.fish_chain.posture import fit_bodies, headings, pose_of
from trackers.gaps import Piece
from trackers.registry import tunable

CHUNK = 8
"""Frames over which a look is averaged; neighbouring frames see the same light and the same beat of the tail."""
_VELOCITY_GAIN = 0.4
_MORE_FEATURES = 4
_LATEST = 40
_MOTION_VOTE = 0.03
"""Way ahead, in lengths of the body, that weighs as much as the balance of one picture."""


class Tracklet:
    """Detections of one fish on successive frames.

    Lines are kept with the same end first on all frames; ``head_first`` is the evidence which end the head is.

    Attributes:
        number: its own. first_frame: of its first detection.
        position_px: (2,) on its last frame. velocity_px: (2,) smoothed, pixels a frame.
        ghosts: after its end, poses (4,) by frame while its fish is merged with others (see ``fit_bodies``).
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


_FAR = 1e6
_FORGOTTEN_FRAMES = 60
"""A fish that a blob has hidden for longer may have left it unseen."""
_COVERED_FRAMES = 12
"""A blob no larger than one fish is not taken for two fish, one right above the other, for longer."""
_MOST_BODIES = 6
_BORDER_PX = 4
_POSE_SHARE = 0.06, 0.06, 0.25, 0.25
"""Deviations of an expected pose: shares of the length of the body, then radians."""


@dataclass(frozen=True)
class TrackletParameters:
    """Parameters of ``TrackletBuilder``; lengths are in lengths of the usual body.

    Attributes:
        gate: greatest distance from the expected place to the next detection.
        margin: if exchanging two fish costs less than this much more distance, both tracklets end.
        grown: a blob this many times as large as the fish before it holds another fish.
        pose_weight_px: pixels of a misfit that one squared deviation from the expected pose counts.
        use_posture: if False, fish are not followed inside blobs of several.
    """

    gate: float = tunable(0.6, 0.2, 1.5)
    margin: float = tunable(0.15, 0.0, 0.6)
    grown: float = tunable(1.4, 1.2, 2.0)
    pose_weight_px: float = tunable(3.0, 0.3, 30.0, log=True)
    use_posture: bool = True


class TrackletBuilder:
    """Extends, ends and begins tracklets.

    Attributes:
        active: tracklets that the last picture extended. ended: all others, in order of their ends.
        ghosts: ended tracklets whose fish is somewhere inside a blob of several.
    """

    def __init__(self, parameters: TrackletParameters) -> None:
        self._parameters = parameters
        self._number = 0
        self.active: list[Tracklet] = []
        self.ended: list[Tracklet] = []
        self.ghosts: list[Tracklet] = []

    def step(self, frame: int, detections: Sequence[Detection], length_px: float) -> list[Tracklet]:
        """Take in the detections of a frame and return the tracklets that begin; ``length_px``: of the usual body."""
        owners = self._assigned(detections, length_px)
        self.ghosts = [each for each in self.ghosts if frame - each.end_frame < _FORGOTTEN_FRAMES]
        inside = self._inside(detections, owners, length_px)
        kept: list[Tracklet] = []
        begun: list[Tracklet] = []
        haunting: list[Tracklet] = []
        for index, detection in enumerate(detections):
            owner, others = owners.get(index), inside[index]
            if owner is not None and not self._holds_more(detection, owner, others):
                owner.append(detection)
                kept.append(owner)
                continue
            members = [*others, owner] if owner is not None else others
            if owner is None and self._is_one(frame, detection, members):
                begun.append(Tracklet(self._number, frame, detection))
                self._number += 1
            elif members:
                haunting += self._haunted(frame, detection, members)
        remaining = {id(each) for each in kept}
        self.ended += [each for each in self.active if id(each) not in remaining]
        self.active = kept + begun
        self.ghosts = haunting
        return begun

    def _assigned(self, detections: Sequence[Detection], length_px: float) -> dict[int, Tracklet]:
        """Return the active tracklet of each detection, by its index; none where two could be exchanged."""
        if not self.active or not detections:
            return {}
        expected = np.array([each.position_px + each.velocity_px for each in self.active])
        places = np.array([each.position_px for each in detections])
        distance = np.linalg.norm(expected[:, None] - places[None], axis=-1)
        # A blob of several has no middle that one fish could be expected at; a large fish's may be taken for one.
        areas = np.array([each.area_px for each in detections])
        grown = areas[None] > self._parameters.grown * np.array([[each.area_px] for each in self.active])
        distance[grown & np.array([each.merged for each in detections])] = _FAR
        cost = np.where(distance < self._parameters.gate * length_px, distance, _FAR)
        rows, columns = linear_sum_assignment(cost)
        pairs = [(row, column) for row, column in zip(rows, columns, strict=True) if cost[row, column] < _FAR]
        margin_px = self._parameters.margin * length_px
        sure = {}
        for row, column in pairs:
            exchanged = [
                distance[row, other] + distance[rival, column] - distance[row, column] - distance[rival, other]
                for rival, other in pairs
                if rival != row
            ]
            if min(exchanged, default=_FAR) > margin_px:
                sure[int(column)] = self.active[row]
        return sure

    def _inside(
        self, detections: Sequence[Detection], owners: dict[int, Tracklet], length_px: float
    ) -> list[list[Tracklet]]:
        """Return for each detection the lost tracklets, just ended or ghosts, that are expected inside it."""
        owned = {id(each) for each in owners.values()}
        inside: list[list[Tracklet]] = [[] for _ in detections]
        for each in [*(each for each in self.active if id(each) not in owned), *self.ghosts]:
            place = each.expected_pose()[:2]
            gaps_px = [_distance_to(detection, place) for detection in detections]
            if gaps_px and min(gaps_px) < 0.5 * self._parameters.gate * length_px:
                inside[int(np.argmin(gaps_px))].append(each)
        return inside

    def _holds_more(self, detection: Detection, owner: Tracklet, others: Sequence[Tracklet]) -> bool:
        """Whether a blob is of more fish than the one that it is assigned to."""
        return bool(others) and detection.area_px > self._parameters.grown * owner.area_px

    def _is_one(self, frame: int, detection: Detection, members: Sequence[Tracklet]) -> bool:
        """Whether a blob without an owner is one fish."""
        if detection.merged:
            return False
        return len([each for each in members if frame - each.end_frame <= _COVERED_FRAMES]) <= 1

    def _haunted(self, frame: int, detection: Detection, members: Sequence[Tracklet]) -> list[Tracklet]:
        """Set where ``members`` are inside a blob, and return them."""
        fitted = list(members)[-_MOST_BODIES:]
        expected = np.array([each.expected_pose() for each in fitted])
        if self._parameters.use_posture:
            lengths = np.array([each.length_px for each in fitted])
            border = int(np.ceil(0.5 * lengths.max())) + _BORDER_PX
            mask = cv2.copyMakeBorder(detection.mask, border, border, border, border, cv2.BORDER_CONSTANT, value=0)
            corner = np.array([*(detection.corner_px - border), 0.0, 0.0])
            deviations = np.array(_POSE_SHARE) * np.stack([lengths, lengths, *np.ones((2, len(fitted)))], axis=1)
            halves = np.array([each.halves_px for each in fitted])
            poses, _ = fit_bodies(mask, expected - corner, lengths, halves, deviations, self._parameters.pose_weight_px)
            for each, pose in zip(fitted, poses + corner, strict=True):
                each.haunt(frame, pose)
        return list(members)


def _distance_to(detection: Detection, place_px: NDArray[np.float64]) -> float:
    """Return the distance in pixels from a point to the outline of a blob; 0 inside it."""
    inside = place_px - detection.corner_px
    column, row = (int(np.floor(value)) for value in inside)
    height, width = detection.mask.shape
    if 0 <= row < height and 0 <= column < width and detection.mask[row, column]:
        return 0.0
    outside = np.maximum(np.maximum(detection.box_xyxy[:2] - place_px, place_px - detection.box_xyxy[2:]), 0.0)
    if np.hypot(*outside) > max(detection.mask.shape):
        return float(np.hypot(*outside))
    rows, columns = np.nonzero(detection.mask)
    return float(np.sqrt(((columns + 0.5 - inside[0]) ** 2 + (rows + 0.5 - inside[1]) ** 2).min()))
