"""A fixed stereo camera, a person who walks to and fro before it, one who crosses and one who stands. No renderer.

Importing it adds the scenario ``fake-follow-v1`` to the catalogue and trackers of the suite ``stereo`` to the registry.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.scenario import Frame, Scenario, Setup
from scenarios.stereo_follow.building import Building, draw_building
from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.robot import ROBOT
from scenarios.stereo_follow.truth import LightEvent, PeopleTruth
from sim.optics import project
from tests.fakes_trackers import NoParameters
from trackers.registry import register
from trackers.types import CameraCommand, CameraModel, CameraRegisters, CameraSettings, Estimate, Observation, Start

CAMERA = CameraModel(160, 120, 120.0, baseline_m=0.12)
POSE = camera_pose(np.zeros(2), 0.0)
RATE_HZ = 15.0
BODY_M = np.array([0.4, 0.5, 1.75])
HIDDEN = range(20, 26)
LIGHTS: dict[int, LightEvent] = {30: "lamp off", 31: "lamp off", 50: "back light"}
WALL_M = 12.0


def target_m(time_s: float) -> NDArray[np.float64]:
    """Return the target's place on the ground (2,)."""
    return np.array([5.0, 1.2 * np.sin(0.8 * time_s)])


def people_m(frame: int) -> NDArray[np.float64]:
    """Return the places of target, crosser and stander (3, 2); the crosser hides the target on frames ``HIDDEN``."""
    middle = target_m(0.5 * (HIDDEN[0] + HIDDEN[-1]) / RATE_HZ)
    crosser = np.array([2.5, 0.5 * middle[1] + 0.3 * (frame - HIDDEN[0] - 2.5)])
    return np.array([target_m(frame / RATE_HZ), crosser, [6.0, -2.5]])


def middles_px(frame: int) -> NDArray[np.float64]:
    """Return the people's centres (3, 2) in the picture."""
    return project(CAMERA, POSE, np.column_stack([people_m(frame), np.full(3, 0.5 * BODY_M[2])]))[0]


def boxes_xyxy(frame: int) -> NDArray[np.float64]:
    """Return boxes (3, 4) of the people."""
    half = 0.5 * BODY_M[[1, 2]] * CAMERA.focal_px / people_m(frame)[:, :1]
    return np.concatenate([middles_px(frame) - half, middles_px(frame) + half], axis=1)


def depth_m(frame: int) -> NDArray[np.float32]:
    """Return the picture's depth (H, W): a wall, people as upright boards before it."""
    depth = np.full((CAMERA.height_px, CAMERA.width_px), WALL_M, dtype=np.float32)
    for person in np.argsort(-people_m(frame)[:, 0]):
        x0, y0, x1, y1 = np.round(boxes_xyxy(frame)[person]).astype(int)
        depth[max(y0, 0) : max(y1, 0), max(x0, 0) : max(x1, 0)] = people_m(frame)[person, 0]
    return depth


@dataclass(frozen=True)
class FakeFollow:
    """Configuration of an episode."""

    summary: str
    frame_count: int = 70
    closed_loop: bool = False


@dataclass
class FakeFollowEpisode:
    """See ``scenarios.scenario.Episode``."""

    configuration: FakeFollow
    closed_loop: bool
    rate_hz: float = RATE_HZ
    _frame: int = -1

    def __post_init__(self) -> None:
        self.frame_count = self.configuration.frame_count
        self.start = Start(CAMERA, boxes_xyxy(0)[0])

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame."""
        self._frame += 1
        image = np.zeros((CAMERA.height_px, CAMERA.width_px, 3), dtype=np.uint8)
        settings = CameraSettings(0.01, 1.0, CameraRegisters(512, 512, 300, 0))
        time_s = self._frame / RATE_HZ
        return Frame(Observation(image, time_s, CAMERA, settings, right_rgb=image), self._truth(self._frame))

    def _truth(self, frame: int) -> PeopleTruth:
        poses = np.tile(np.eye(4), (3, 1, 1))
        poses[:, :2, 3] = people_m(frame)
        hidden = frame in HIDDEN
        ids = np.zeros((CAMERA.height_px, CAMERA.width_px), dtype=np.int32)
        return PeopleTruth(
            frame=frame,
            time_s=frame / RATE_HZ,
            T_world_camera=POSE,
            names=("target", "crosser", "stander"),
            kinds=("person",) * 3,
            T_world_object=poses,
            size_m=np.tile(BODY_M, (3, 1)),
            speed_mps=np.ones(3),
            position_px=middles_px(frame),
            box_xyxy=boxes_xyxy(frame),
            instance_id=np.arange(3),
            visible_fraction=np.array([0.0 if hidden else 1.0, 1.0, 1.0]),
            state=np.array(["occluded" if hidden else "in", "in", "in"]),
            side=np.full(3, ""),
            frames_since_exit=np.full(3, -1),
            instance_map=ids,
            depth_m=depth_m(frame),
            exposure_s=0.01,
            gain=1.0,
            T_world_right=POSE,
            right_instance_map=ids,
            right_depth_m=depth_m(frame),
            occluder=np.array([1 if hidden else -1, -1, -1]),
            illuminance_lx=np.full(3, 200.0),
            place="hall" if frame < 40 else "corridor",
            light_event=LIGHTS.get(frame),
            near_person=15 <= frame < 35,
            registers=CameraRegisters(512, 512, 300, 0),
        )

    def map_of(self) -> Building:
        """Return some building; the people ignore it."""
        return draw_building(draw_floor_plan(np.random.default_rng(0)), np.random.default_rng(0))

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return a blank picture."""
        return np.zeros((int(scale * CAMERA.height_px), int(scale * CAMERA.width_px), 3), dtype=np.uint8)

    def close(self) -> None:
        """There is nothing to free."""


class _Follower:
    """Knows all people's ways; answers with the target's place and distance."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        pass

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        pass

    def update(self, observation: Observation) -> Estimate:
        return self.told_at(round(observation.time_s * RATE_HZ))

    def told_at(self, frame: int) -> Estimate:
        if frame in HIDDEN:
            return Estimate(middles_px(frame)[0], in_view_probability=0.1)
        return Estimate(middles_px(frame)[0], in_view_probability=0.9, depth_m=float(people_m(frame)[0, 0]))


@register("follow_knowing", role="ours", summary="knows the way", suites=("stereo",))
class FollowKnowing(_Follower):
    """The base behaviour."""


@register("follow_single", role="as-written", summary="knows the way, in the picture alone", suites=("stereo",))
class FollowSingle(_Follower):
    """Has no depth and no probability: it points at the crosser, who hides the target."""

    def told_at(self, frame: int) -> Estimate:
        return Estimate(middles_px(frame)[0])


@register("follow_taken", role="baseline", summary="follows the crosser", suites=("stereo",))
class FollowTaken(_Follower):
    """Goes with the crosser from the occlusion on."""

    def told_at(self, frame: int) -> Estimate:
        person = 0 if frame < HIDDEN[0] else 1
        return Estimate(middles_px(frame)[person], depth_m=float(people_m(frame)[person, 0]))


@register("follow_raises", role="baseline", summary="raises on frame 40", suites=("stereo",))
class FollowRaises(_Follower):
    """Has a bug."""

    def told_at(self, frame: int) -> Estimate:
        if frame == 40:
            raise RuntimeError("a bug")
        return super().told_at(frame)


def fake_episode(setup: Setup) -> FakeFollowEpisode:
    """Build one episode; all seeds are alike."""
    return FakeFollowEpisode(setup.preset, setup.closed_loop)


FAKE_FOLLOW = Scenario(
    id="fake-follow-v1",
    summary="a person before a camera",
    start="the person's box",
    stage=fake_episode,
    presets={"tiny": FakeFollow("a fixed camera")},
    classes={"person": "person"},
    carrier=ROBOT,
    truth=PeopleTruth,
)
catalog.register(catalog.Entry("fake-follow-v1", "tests.benchmarks.judges.follow.fake_follow:FAKE_FOLLOW"))
