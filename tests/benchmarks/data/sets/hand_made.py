"""A small stored data set of which every number is known: two cars, one out for a while and one that stays out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import write_episode
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import Request
from scenarios.scenario import Frame
from tests.benchmarks.fake_episode import CAMERA, HEIGHT, WIDTH, FakeEpisode
from trackers.types import CameraCommand, Start

FRAMES, SEEDS = 30, (0, 1)
OBJECT_SIZE = (20, 12)
CHANNELS = (
    "image_rgb", "right_rgb", "counts", "instance_map", "depth_m", "flow_px", "normal_world",
)  # fmt: skip
BASELINE_M = 0.25
STEREO = replace(CAMERA, baseline_m=BASELINE_M)
_TARGET = [*["in"] * 10, *["out"] * 5, *["in"] * 15]
_TRAFFIC = [*["absent"] * 5, *["out"] * 5, *["in"] * 10, *["out"] * 10]
STATES = np.array([_TARGET, _TRAFFIC]).T
"""(30, 2) by frame. Frame-outs: of the target one of 5 frames; of the other one of 10, to the end of the episode."""


@dataclass
class HandMadeEpisode(FakeEpisode):
    """Two cars, see ``STATES``; the right picture of every third frame was lost; the speed of what is absent is 99."""

    frame_count: int = FRAMES

    @property
    def start(self) -> Start:
        return Start(STEREO, super().start.box_xyxy)

    def step(self, command: CameraCommand | None = None) -> Frame:
        frame = super().step(command)
        k = self._frame
        states = STATES[k % FRAMES]
        corners = np.array([[30.0, 20.0], [90.0, 60.0]])
        corners[states != "in"] = (WIDTH + 100.0, 20.0)
        boxes = np.concatenate([corners, corners + OBJECT_SIZE], axis=1)
        instances = np.full((HEIGHT, WIDTH), -1, dtype=np.int32)
        for car, (x0, y0, x1, y1) in enumerate(boxes.astype(int)):
            instances[y0:y1, x0:x1] = 7 + 3 * car
        depth = np.full((HEIGHT, WIDTH), 40.0, dtype=np.float32)
        depth[:10] = np.inf
        flow = np.zeros((HEIGHT, WIDTH, 2), dtype=np.float32)
        flow[:10] = np.nan
        poses = np.stack([np.eye(4)] * 2)
        poses[:, :3, 3] = [(1.0, 2.0, 0.5), (-3.0, 0.0, 0.0)]
        truth = replace(
            frame.truth,
            names=("target", "traffic-1"),
            kinds=("sedan", "sedan"),
            T_world_object=poses,
            size_m=np.array([[4.5, 1.8, 1.5]] * 2),
            # Those of two objects, from their sizes.
            bounds_m=np.empty((0, 2, 3)),
            glare_fraction=np.zeros(2),
            speed_mps=np.where(states == "absent", 99.0, [8.0, 4.0]),
            position_px=corners + np.array(OBJECT_SIZE) / 2,
            box_xyxy=boxes,
            instance_id=np.array([7, 10]),
            visible_fraction=np.where(states == "in", 1.0, 0.0),
            state=states,
            side=np.where(states == "out", "right", ""),
            frames_since_exit=np.where(states == "out", 0, -1),
            on_road=k < 15,
            instance_map=instances,
            depth_m=depth,
            flow_px=flow,
            exposure_s=0.001 * (1 + k),
        )
        observation = replace(
            frame.observation,
            camera=STEREO,
            right_rgb=None if k % 3 == 0 else frame.observation.image_rgb,
            counts=np.full((HEIGHT, WIDTH), 3000 + k, dtype=np.uint16),
        )
        return Frame(observation, truth)

    def normals(self) -> NDArray[np.float32]:
        return np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), (HEIGHT, WIDTH, 3))


def write_set(
    folder: Path, channels: tuple[str, ...] = CHANNELS, frames: int = FRAMES, pictures: str = "blosc2"
) -> DataSet:
    """Write it, without the last of the seeds asked for; return it opened."""
    folder.mkdir(parents=True, exist_ok=True)
    request = Request("road-town-v2", "quick", (0, 3), channels, pictures)
    files, root = place_of(str(folder))
    (folder / REQUEST).write_text(request.as_json())
    for seed in SEEDS:
        write_episode(files, root, request, seed, HandMadeEpisode(frames))
    return DataSet(str(folder))
