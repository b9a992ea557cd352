"""One episode of ``stereo-follow``: the plan, frame by frame."""

from __future__ import annotations

import numpy as np

from scenarios.kept_world import KeptWorld
from scenarios.scenario import Frame, RendererName
from scenarios.stage import Stage, covers_all
from scenarios.stereo_follow.building import Building
from scenarios.stereo_follow.camera import camera, camera_model, camera_pose, registers
from scenarios.stereo_follow.light_events import LightEvents
from scenarios.stereo_follow.lighting import build, illuminance_lx, set_light
from scenarios.stereo_follow.odometry import Odometry
from scenarios.stereo_follow.people import People
from scenarios.stereo_follow.plan import TARGET, Plan
from scenarios.stereo_follow.rig import StereoPair, StereoRig
from scenarios.stereo_follow.robot import Robot
from scenarios.stereo_follow.truth import PeopleTruth
from scenarios.truth import TruthExtent
from sim.rng import generator
from sim.shaders.baked.shader import BakedLightShader
from sim.world import World
from trackers.types import CameraCommand, EgoPose, Start

NOD_RAD, NOD_KEPT = np.deg2rad(0.12), 0.8
"""The robot shakes: standard deviation of nod and roll, and their autoregression coefficient."""
_NEAR_M = 1.5
_SHADOW_TEXELS = 1024


class StereoFollowEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    def __init__(
        self, plan: Plan, renderer: RendererName, truth: TruthExtent = "all", kept: KeptWorld | None = None
    ) -> None:
        self._covers_all = covers_all(truth)
        preset, crowd = plan.preset, plan.crowd
        self.plan = plan
        self._camera = camera(preset.width_px, preset.height_px)
        if kept is None:
            world = World()
            baked = build(world, plan.building)
        else:
            world, baked = kept.vacated(), kept.content.baked
        self._people = People(world, plan)
        self._baked_light = BakedLightShader(world, baked, shadow_texels=_SHADOW_TEXELS, panels_raised=False)
        self._pair = StereoRig(world, self._camera, renderer, plan.seed)
        super().__init__(
            world,
            self._pair,
            frame_count=preset.frame_count,
            rate_hz=preset.rate_hz,
            closed_loop=plan.closed_loop,
        )
        self._odometry = Odometry(generator(plan.seed, "odometry")) if preset.odometry else None
        shake = generator(plan.seed, "shake").normal(0.0, NOD_RAD, (preset.frame_count, 2))
        for frame in range(1, preset.frame_count):
            shake[frame] = NOD_KEPT * shake[frame - 1] + (1 - NOD_KEPT**2) ** 0.5 * shake[frame]
        self._shake = shake
        self._robot = Robot(plan.building.plan, crowd.robot_m[0], crowd.robot_heading_rad[0], preset.rate_hz)
        self._events = LightEvents(plan.places, plan.light.switched, preset.rate_hz)
        self._move_to(0)
        nothing = np.full((preset.height_px, preset.width_px), -1, np.int32)
        boxes_alone = np.zeros(len(self._people.names), dtype=np.bool_)
        seen = self._people.seen(self._camera, self._T_world_camera, nothing, boxes_alone)
        self._first_box_xyxy = seen[TARGET].box_xyxy

    @property
    def start(self) -> Start:
        """The person's box in the first left picture."""
        return Start(camera_model(self._camera), box_xyxy=self._first_box_xyxy.copy())

    @property
    def _shader(self) -> BakedLightShader:
        return self._baked_light

    def map_of(self) -> Building:
        """Return the building."""
        return self.plan.building

    def _obey(self, command: CameraCommand) -> None:
        self._robot.drive(command)

    def _move_to(self, frame: int) -> None:
        self._people.move_to(frame)
        set_light(self._shader, self.plan.light, frame)
        crowd = self.plan.crowd
        if not self.closed_loop:
            self._robot.place_m, self._robot.heading_rad = crowd.robot_m[frame], float(crowd.robot_heading_rad[frame])
        self._T_world_camera = camera_pose(self._robot.place_m, self._robot.heading_rad, *self._shake[frame])

    def _take(self, frame: int) -> Frame:
        pair = self._pair.take_pair(self._shader, self._T_world_camera, frame)
        # In place: the maps belong to this frame alone, and nothing else needs the parts.
        for capture in (pair.left, pair.right):
            self._people.merge(capture.instance_id)
        truth = self._truth(frame, pair)
        is_lost = bool(self.plan.dropped[frame])
        return Frame(self._pair.observation(pair, truth.time_s, self._measured_pose(), is_lost=is_lost), truth)

    def _measured_pose(self) -> EgoPose | None:
        if self._odometry is None:
            return None
        return EgoPose(self._odometry.measure(self._robot.place_m, self._robot.heading_rad))

    def _truth(self, frame: int, pair: StereoPair) -> PeopleTruth:
        people, pose, left, right = self._people, self._T_world_camera, pair.left, pair.right
        distance_m = np.linalg.norm((people.T_world_person[:, :3, 3] - pose[:3, 3])[:, :2], axis=1)
        is_close = distance_m < _NEAR_M
        is_target = np.arange(len(distance_m)) == TARGET
        asked = np.full(len(distance_m), self._covers_all) | is_target
        seen = people.seen(self._camera, pose, left.instance_id, asked | is_close)
        fractions = np.array([each.visible_fraction for each in seen])
        lux = illuminance_lx(self._shader, people.chests_m(), pose[:3, 3])
        return PeopleTruth(
            **self._seen(
                left,
                T_world_object=people.T_world_person,
                size_m=people.size_m,
                box_xyxy=np.array([each.box_xyxy for each in seen]),
                visible_fraction=np.where(asked, fractions, np.nan),
            ),
            names=people.names,
            bounds_m=people.bounds_m(),
            kinds=self.plan.crowd.kinds,
            instance_id=people.instance_id,
            speed_mps=np.array([walk.speed_mps[frame] for walk in self.plan.crowd.walks]),
            T_world_right=pair.T_world_right,
            right_instance_map=right.instance_id,
            right_depth_m=right.depth_m,
            occluder=np.where(asked, [self._person_of(each.hidden_by) for each in seen], -1),
            illuminance_lx=lux,
            place=self.plan.places[frame],
            light_event=self._events.follow(frame, left.picture, float(lux[TARGET])),
            near_person=bool((is_close & ~is_target & (fractions > 0)).any()),
            registers=registers(left.picture.settings),
        )

    def _person_of(self, instance_id: int) -> int:
        return -1 if instance_id < 0 else int(np.flatnonzero(self._people.instance_id == instance_id)[0])
