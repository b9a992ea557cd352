"""A world of one line of arithmetic: cars on circles, a camera that looks straight down, blank pictures.

Importing it adds the scenario ``fake-town-v1`` to the catalogue and trackers for it, good and bad, to the registry.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.road_town.flight import HELICOPTER
from scenarios.road_town.truth import Light, RoadTruth
from scenarios.scenario import Frame, Scenario, Setup
from scenarios.visibility import Exits, states_of
from sim.optics import look_down_pose, project
from trackers.types import CameraCommand, CameraModel, CameraSettings, EgoPose, Observation, Start

HEIGHT_M = 60.0
CAMERA = CameraModel(160, 120, 140.0)
SIZE_M = np.array([4.5, 1.8, 1.5])
RADIUS_M, TURN_RAD_S = 40.0, 0.5
"""The target's circle: about half of it lies outside the picture of a camera above its rim."""


def car_position_m(time_s: float, car: int = 0) -> NDArray[np.float64]:
    """Where a car is; the others follow on the same circle."""
    angle = TURN_RAD_S * time_s - 0.6 * car
    return RADIUS_M * np.array([np.cos(angle), np.sin(angle)])


@dataclass(frozen=True)
class FakeTown:
    """Configuration of an episode."""

    summary: str
    frame_count: int = 240
    rate_hz: float = 15.0
    width_px: int = CAMERA.width_px
    height_px: int = CAMERA.height_px
    closed_loop: bool = False


@dataclass
class FakeEpisode:
    """See ``scenarios.scenario.Episode``."""

    configuration: FakeTown
    closed_loop: bool
    phase_s: float

    def __post_init__(self) -> None:
        self.frame_count = self.configuration.frame_count
        self.rate_hz = self.configuration.rate_hz
        self._frame = 0
        self._centre_m = np.array([RADIUS_M, 0.0])
        self._exits = Exits(CAMERA, 3)
        self.start = Start(CAMERA, self._boxes(self._pose(), 0.0)[1][0])

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame."""
        if command is not None:
            self._centre_m = self._centre_m + np.array([command.forward_mps, -command.right_mps]) / self.rate_hz
        T_world_camera, time_s = self._pose(), self._frame / self.rate_hz
        truth = self._truth(T_world_camera, time_s)
        self._frame += 1
        image = np.zeros((CAMERA.height_px, CAMERA.width_px, 3), dtype=np.uint8)
        observation = Observation(image, time_s, CAMERA, CameraSettings(0.01, 1.0), EgoPose(T_world_camera))
        return Frame(observation, truth)

    def map_of(self) -> None:
        """There is no map."""

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return a blank picture."""
        return np.zeros((int(scale * CAMERA.height_px), int(scale * CAMERA.width_px), 3), dtype=np.uint8)

    def normals(self) -> NDArray[np.float32]:
        """Return those of flat ground."""
        return np.tile(np.array([0, 0, 1], np.float32), (CAMERA.height_px, CAMERA.width_px, 1))

    def close(self) -> None:
        """There is nothing to free."""

    def _pose(self) -> NDArray[np.float64]:
        return look_down_pose(np.array([*self._centre_m, HEIGHT_M]), 0.0, 0.0, 0.0)

    def _cars(self, time_s: float) -> NDArray[np.float64]:
        poses = np.tile(np.eye(4), (3, 1, 1))
        for car in range(3):
            heading = TURN_RAD_S * (time_s + self.phase_s) - 0.6 * car + np.pi / 2
            poses[car, :2, :2] = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
            poses[car, :2, 3] = car_position_m(time_s + self.phase_s, car)
        return poses

    def _boxes(self, T_world_camera: NDArray[np.float64], time_s: float) -> tuple[NDArray[np.float64], ...]:
        signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1)]) * SIZE_M
        cars = self._cars(time_s)
        corners = np.einsum("nij,kj->nki", cars[:, :3, :3], signs) + cars[:, None, :3, 3]
        pixels, _ = project(CAMERA, T_world_camera, corners)
        middles, _ = project(CAMERA, T_world_camera, cars[:, :3, 3] + [0, 0, 0.5 * SIZE_M[2]])
        return middles, np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1)

    def _truth(self, T_world_camera: NDArray[np.float64], time_s: float) -> RoadTruth:
        position_px, boxes = self._boxes(T_world_camera, time_s)
        state = states_of(CAMERA, boxes, np.ones(3))
        side, frames_since_exit = self._exits.follow(state, boxes)
        return RoadTruth(
            frame=self._frame,
            time_s=time_s,
            T_world_camera=T_world_camera,
            names=("target", "traffic-1", "traffic-2"),
            kinds=("saloon",) * 3,
            T_world_object=self._cars(time_s),
            size_m=np.tile(SIZE_M, (3, 1)),
            speed_mps=np.full(3, RADIUS_M * TURN_RAD_S),
            position_px=position_px,
            box_xyxy=boxes,
            instance_id=np.arange(3),
            visible_fraction=np.select([state == "out", state == "in"], [0.0, 1.0], 0.5),
            state=state,
            side=side,
            frames_since_exit=frames_since_exit,
            on_road=True,
            turning=False,
            instance_map=_drawn(boxes),
            depth_m=np.full((CAMERA.height_px, CAMERA.width_px), HEIGHT_M, dtype=np.float32),
            flow_px=np.zeros((CAMERA.height_px, CAMERA.width_px, 2), dtype=np.float32),
            background_motion=np.eye(3),
            light=Light(np.array([0.0, 0.0, 1.0]), 1e5, 1e4),
            exposure_s=0.01,
            gain=1.0,
        )


def _drawn(box_xyxy: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return the instance map of boxes (N, 4); -1 is the ground."""
    drawn = np.full((CAMERA.height_px, CAMERA.width_px), -1, np.int32)
    for k, (x0, y0, x1, y1) in reversed(list(enumerate(np.maximum(box_xyxy, 0).round().astype(int)))):
        drawn[y0:y1, x0:x1] = k
    return drawn


class UnhashedSeeds(Scenario):
    """A scenario whose episodes get the seeds as they are given."""

    def _own(self, seed: int) -> int:
        return seed


def fake_episode(setup: Setup) -> FakeEpisode:
    """Build one episode; the seed sets where on the circle the cars start."""
    return FakeEpisode(setup.preset, setup.closed_loop, phase_s=0.01 * (setup.seed % 10))


FAKE_TOWN = UnhashedSeeds(
    id="fake-town-v1",
    summary="cars on circles",
    start="the car's box",
    stage=fake_episode,
    presets={"tiny": FakeTown("a set path"), "tiny-loop": FakeTown("the tracker steers", closed_loop=True)},
    classes={"saloon": "car"},
    carrier=HELICOPTER,
    truth=RoadTruth,
)
catalog.register(catalog.Entry("fake-town-v1", "tests.fakes_scenario:FAKE_TOWN"))
importlib.import_module("tests.fakes_trackers")
