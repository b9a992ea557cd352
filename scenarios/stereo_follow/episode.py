"""One episode of ``stereo-follow``: the plan carried out, frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import Frame, RendererName
from scenarios.stereo_follow.building import Building
from scenarios.stereo_follow.camera import camera, camera_pose, registers
from scenarios.stereo_follow.light_events import LightEvents
from scenarios.stereo_follow.lighting import build, illuminance_lx, set_light
from scenarios.stereo_follow.odometry import Odometry
from scenarios.stereo_follow.people import People
from scenarios.stereo_follow.plan import TARGET, Plan
from scenarios.stereo_follow.rig import StereoPair, StereoRig
from scenarios.stereo_follow.robot import Robot
from scenarios.stereo_follow.truth import PeopleTruth
from scenarios.truth import TruthExtent
from scenarios.visibility import Exits, centres_px, state_of
from sim.checks import check
from sim.rng import generator
from sim.shaders.baked.shader import BakedLightShader
from sim.world import World
from trackers.types import CameraCommand, EgoPose

NOD_RAD, NOD_KEPT = np.deg2rad(0.12), 0.8
"""The robot shakes: standard deviation of its nod and roll, and what is left of them from frame to frame."""
_NEAR_M = 1.5


class StereoFollowEpisode:
    """See ``scenarios.scenario.Episode``."""

    def __init__(self, plan: Plan, renderer: RendererName, truth: TruthExtent = "all") -> None:
        check("truth", truth in ("all", "target"), "'all' or 'target'", truth)
        self._tells_all = truth == "all"
        preset = plan.preset
        self.plan = plan
        self.frame_count, self.rate_hz, self.closed_loop = preset.frame_count, preset.rate_hz, plan.closed_loop
        self._camera = camera(preset.width_px, preset.height_px)
        self._world = World()
        baked = build(self._world, plan.building)
        self._people = People(self._world, plan)
        self._shader = BakedLightShader(self._world, baked)
        self._rig = StereoRig(self._world, self._camera, renderer, plan.seed)
        self._odometry = Odometry(generator(plan.seed, "odometry")) if preset.odometry else None
        shake = generator(plan.seed, "shake").normal(0.0, NOD_RAD, (preset.frame_count, 2))
        for frame in range(1, preset.frame_count):
            shake[frame] = NOD_KEPT * shake[frame - 1] + (1 - NOD_KEPT**2) ** 0.5 * shake[frame]
        self._shake = shake
        crowd = plan.crowd
        self._robot = Robot(plan.building.plan, crowd.robot_m[0], crowd.robot_heading_rad[0], preset.rate_hz)
        self._events = LightEvents(plan.places, plan.light.switched, preset.rate_hz)
        self._exits = Exits(self._camera)
        self._frame = -1
        self._move_to(0)
        nothing = np.full((preset.height_px, preset.width_px), -1, np.int32)
        nobody = np.zeros(len(self._people.names), dtype=np.bool_)
        self.target_box_xyxy = self._people.seen(self._camera, self._T_world_camera, nothing, nobody)[TARGET].box_xyxy

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame; see ``Episode.step``.

        Raises:
            ValueError: if a command is missing in closed loop, or given on a set path.
            StopIteration: after the last frame.
        """
        frame = self._frame + 1
        if frame >= self.frame_count:
            raise StopIteration(f"episode: expected at most {self.frame_count} steps")
        if self.closed_loop and frame > 0:
            if command is None:
                raise ValueError(
                    "command: expected a CameraCommand, since this episode is driven in closed loop, got None"
                )
            self._robot.drive(command)
        elif command is not None and not self.closed_loop:
            raise ValueError("command: expected None, since this episode follows a set path, got a CameraCommand")
        self._move_to(frame)
        self._frame = frame
        return self._capture()

    def map_of(self) -> Building:
        """Return the building."""
        return self.plan.building

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high; see ``Episode.larger_view``."""
        return self._rig.larger_view(self._shader, self._T_world_camera, scale)

    @property
    def world(self) -> World:
        """The bodies, where they are now; for other renderers to draw."""
        return self._world

    def close(self) -> None:
        """Free the world."""
        self._world.close()

    def _move_to(self, frame: int) -> None:
        self._people.move_to(frame)
        set_light(self._shader, self.plan.light, frame)
        crowd = self.plan.crowd
        if not self.closed_loop:
            self._robot.place_m, self._robot.heading_rad = crowd.robot_m[frame], float(crowd.robot_heading_rad[frame])
        self._T_world_camera = camera_pose(self._robot.place_m, self._robot.heading_rad, *self._shake[frame])

    def _capture(self) -> Frame:
        frame = self._frame
        pair = self._rig.take(self._shader, self._T_world_camera, frame)
        # In place: the maps are this frame's own, and nobody else asks for the parts.
        for capture in (pair.left, pair.right):
            self._people.merge(capture.instance_id)
        truth = self._truth(pair)
        is_lost = bool(self.plan.dropped[frame])
        return Frame(self._rig.observation(pair, truth.time_s, self._measured_pose(), is_lost=is_lost), truth)

    def _measured_pose(self) -> EgoPose | None:
        if self._odometry is None:
            return None
        return EgoPose(self._odometry.measure(self._robot.place_m, self._robot.heading_rad))

    def _truth(self, pair: StereoPair) -> PeopleTruth:
        people, pose, frame, left, right = self._people, self._T_world_camera, self._frame, pair.left, pair.right
        distance_m = np.linalg.norm((people.T_world_person[:, :3, 3] - pose[:3, 3])[:, :2], axis=1)
        is_close = distance_m < _NEAR_M
        is_target = np.arange(len(distance_m)) == TARGET
        asked = np.full(len(distance_m), self._tells_all) | is_target
        seen = people.seen(self._camera, pose, left.instance_id, asked | is_close)
        boxes = np.array([each.box_xyxy for each in seen])
        fractions = np.array([each.visible_fraction for each in seen])
        state = state_of(self._camera, boxes[TARGET], fractions[TARGET])
        side, frames_since_exit = self._exits.follow(state, boxes[TARGET])
        used = left.picture.settings
        lux = illuminance_lx(self._shader, people.chests_m(), pose[:3, 3])
        return PeopleTruth(
            frame=frame,
            time_s=frame / self.rate_hz,
            T_world_camera=pose,
            target=TARGET,
            names=people.names,
            kinds=self.plan.crowd.kinds,
            T_world_object=people.T_world_person.copy(),
            size_m=people.size_m,
            speed_mps=np.array([walk.speed_mps[frame] for walk in self.plan.crowd.walks]),
            position_px=centres_px(self._camera, pose, people.T_world_person, people.size_m),
            box_xyxy=boxes,
            instance_id=people.instance_id,
            visible_fraction=np.where(asked, fractions, np.nan),
            state=state,
            side=side,
            frames_since_exit=frames_since_exit,
            instance_map=left.instance_id,
            depth_m=left.depth_m,
            exposure_s=used.exposure_s,
            gain=used.gain,
            T_world_right=pair.T_world_right,
            right_instance_map=right.instance_id,
            right_depth_m=right.depth_m,
            occluder=np.where(asked, [self._person_of(each.hidden_by) for each in seen], -1),
            illuminance_lx=lux,
            place=self.plan.places[frame],
            light_event=self._events.follow(frame, left.picture, float(lux[TARGET])),
            near_person=bool((is_close & ~is_target & (fractions > 0)).any()),
            registers=registers(used),
        )

    def _person_of(self, instance_id: int) -> int:
        return -1 if instance_id < 0 else int(np.flatnonzero(self._people.instance_id == instance_id)[0])
