"""A hand-drawn episode: a red box drives across striped ground and out of the picture. No renderer."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.run.guards import GuardedController
from benchmarks.run.jobs import Job, OpenJob
from benchmarks.run.selection import job_on
from scenarios.loop import FromPictures, Loop
from scenarios.road_town.truth import Light, RoadTruth
from scenarios.scenario import Episode, Frame
from trackers.protocols import Controller, Tracker
from trackers.types import CameraCommand, CameraModel, Estimate, Observation, Start

WIDTH, HEIGHT = 160, 120
CAMERA = CameraModel(WIDTH, HEIGHT, 150.0)
JOB = job_on("frame-out", "road-town-v2", "quick", 0)


def draw_ground(width: int, height: int, box: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return stripes around the picture's centre with a red box; both given from that centre."""
    x = np.arange(width) - width // 2
    image = np.empty((height, width, 3), dtype=np.uint8)
    image[:] = np.where(x // 16 % 2 == 0, 120, 90)[None, :, None]
    x0, y0, x1, y1 = (box + np.tile([width // 2, height // 2], 2)).astype(int)
    image[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)] = (200, 40, 30)
    return image


@dataclass
class FakeEpisode:
    """See ``scenarios.scenario.Episode``; the box moves 8 px a frame to the right, 20 x 12 px in size."""

    frame_count: int = 30
    rate_hz: float = 15.0
    closed_loop: bool = False
    commands: list[CameraCommand | None] = field(default_factory=list)
    closed: bool = False
    _frame: int = -1

    @property
    def start(self) -> Start:
        return Start(CAMERA, self._box(0) + np.tile([WIDTH / 2, HEIGHT / 2], 2))

    def _box(self, frame: int) -> NDArray[np.float64]:
        return np.array([-40.0 + 8 * frame, -6.0, -20.0 + 8 * frame, 6.0])

    def step(self, command: CameraCommand | None = None) -> Frame:
        self.commands.append(command)
        self._frame += 1
        image = draw_ground(WIDTH, HEIGHT, self._box(self._frame))
        return Frame(Observation(image, self._frame / self.rate_hz, CAMERA), self._truth())

    def _truth(self) -> RoadTruth:
        box = self._box(self._frame) + np.tile([WIDTH / 2, HEIGHT / 2], 2)
        state = "out" if box[0] >= WIDTH else "partial" if box[2] > WIDTH else "in"
        empty = np.zeros((HEIGHT, WIDTH))
        return RoadTruth(
            frame=self._frame,
            time_s=self._frame / self.rate_hz,
            T_world_camera=np.eye(4),
            names=("target",),
            kinds=("car",),
            T_world_object=np.eye(4)[None],
            size_m=np.array([[4.5, 1.8, 1.5]]),
            speed_mps=np.array([8.0]),
            position_px=0.5 * (box[:2] + box[2:])[None],
            box_xyxy=box[None],
            instance_id=np.array([1]),
            visible_fraction=np.array([float(state == "in")]),
            state=np.array([state]),
            side=np.array(["right" if state == "out" else ""]),
            frames_since_exit=np.array([max(self._frame - 15, 0) if state == "out" else -1]),
            on_road=True,
            turning=False,
            instance_map=empty.astype(np.int32),
            depth_m=empty.astype(np.float32),
            flow_px=np.zeros((HEIGHT, WIDTH, 2), dtype=np.float32),
            background_motion=np.eye(3),
            light=Light(np.array([0.0, 0, 1]), 50_000.0, 10_000.0),
            exposure_s=0.002,
            gain=1.0,
        )

    def map_of(self) -> Any:
        return None

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        return draw_ground(int(WIDTH * scale), int(HEIGHT * scale), self._box(self._frame))

    def close(self) -> None:
        self.closed = True


def live(episode: Episode, tracker: Tracker, controller: Controller | None = None, job: Job = JOB) -> OpenJob:
    """Return an episode as that of a job, with one tracker and what steers by it."""
    pilot = None if controller is None else GuardedController(lambda: controller, 60.0)
    return OpenJob(job, Loop(episode, [FromPictures(tracker)]), [], pilot)


class FakeTracker:
    """Knows the fake box's motion, a little off, and says how sure it is of seeing it."""

    def __init__(self) -> None:
        self._position = np.zeros(2)
        self._rng = np.random.default_rng(5)

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self._position = 0.5 * (box_xyxy[:2] + box_xyxy[2:])

    def update(self, observation: Observation) -> Estimate:
        self._position = self._position + np.array([7.7, 0.4])
        return Estimate(
            self._position,
            box_xyxy=np.tile(self._position, 2) + np.array([-10.0, -6.0, 10.0, 6.0]),
            in_view_probability=float(self._position[0] < WIDTH),
            particles_px=self._position + self._rng.normal(0, 6, (200, 2)),
        )
