"""A real sequence as an episode: the loop of simulated ones runs through it. Of its truth the boxes alone are known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import UnreadableSequence
from benchmarks.data.sequences.sequence import BoxedSequence, read_picture, short
from scenarios.scenario import Frame
from scenarios.truth import Truth
from trackers.types import CameraCommand, CameraModel, Observation, Start

USUAL_FOCAL = 1.2
"""Focal length over the longer side of the picture where none is known: COLMAP's ``default_focal_length_factor``
(Schönberger, Frahm, Structure-from-motion revisited, CVPR 2016, and its documentation).
"""
TARGET = "target"


class SequenceEpisode:
    """See ``scenarios.scenario.Episode``. Pictures are read when they are needed; none is kept but the latest.

    The target's state is ``in`` where it has a box, else ``out``: layouts do not tell whether it is hidden or outside
    the picture. What is in metres is NaN.
    """

    closed_loop = False

    def __init__(self, sequence: BoxedSequence) -> None:
        """Read the first picture. Raises UnreadableSequence if it is broken."""
        self._sequence = sequence
        self.frame_count = len(sequence.pictures)
        self.rate_hz = sequence.rate_hz
        self._next = 0
        self._last_seen = 0
        height, width = read_picture(sequence.pictures[0]).shape[:2]
        self._camera = CameraModel(width, height, USUAL_FOCAL * max(width, height))

    @property
    def start(self) -> Start:
        """See ``Episode``."""
        return Start(self._camera, self._sequence.box_xyxy[0].copy())

    def step(self, command: CameraCommand | None = None) -> Frame:
        """See ``Episode``. Raises UnreadableSequence for a picture that is broken or of another size."""
        k, path = self._next, self._sequence.pictures[self._next]
        picture = read_picture(path)
        height, width = self._camera.height_px, self._camera.width_px
        if picture.shape[:2] != (height, width):
            got = f"{picture.shape[1]} x {picture.shape[0]}"
            raise UnreadableSequence(
                f"{short(path, 3)}: expected {width} x {height} pixels as the first one, got {got}"
            )
        self._next += 1
        return Frame(Observation(picture, k / self.rate_hz, self._camera), self._truth(k))

    def map_of(self) -> Any:
        """See ``Episode``. None is known."""
        return None

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """See ``Episode``. Raises ValueError: the surroundings of a real picture are not known."""
        raise ValueError(f"scale: expected none for a real sequence, which has no larger view, got {scale:g}")

    def normals(self) -> NDArray[np.float32]:
        """See ``Episode``. None are known, so all are 0."""
        return np.zeros((self._camera.height_px, self._camera.width_px, 3), np.float32)

    def close(self) -> None:
        """See ``Episode``. Nothing is open."""

    def _truth(self, k: int) -> Truth:
        box_xyxy = self._sequence.box_xyxy[k]
        seen = not np.isnan(box_xyxy).any()
        self._last_seen = k if seen else self._last_seen
        return Truth(
            frame=k,
            time_s=k / self.rate_hz,
            T_world_camera=np.full((4, 4), np.nan),
            names=(TARGET,),
            kinds=("unknown",),
            T_world_object=np.full((1, 4, 4), np.nan),
            size_m=np.full((1, 3), np.nan),
            speed_mps=np.full(1, np.nan),
            position_px=0.5 * (box_xyxy[:2] + box_xyxy[2:])[None],
            box_xyxy=box_xyxy[None].copy(),
            instance_id=np.zeros(1, np.int64),
            visible_fraction=np.array([np.nan if seen else 0.0]),
            state=np.array(["in" if seen else "out"]),
            side=np.array([""]),
            frames_since_exit=np.array([-1 if seen else k - self._last_seen - 1]),
            instance_map=np.empty((0, 0), np.int32),
            depth_m=np.empty((0, 0), np.float32),
            exposure_s=float("nan"),
            gain=float("nan"),
        )
