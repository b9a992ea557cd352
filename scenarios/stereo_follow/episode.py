"""One episode of ``stereo-follow``: the plan, frame by frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.objects import Labels
from scenarios.scenario import Setup
from scenarios.stereo_follow.building import Building
from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.light_events import LightEvents
from scenarios.stereo_follow.lighting import build, illuminance_lx, set_light
from scenarios.stereo_follow.people import People
from scenarios.stereo_follow.plan import TARGET, make_plan
from scenarios.stereo_follow.rig import StereoStage
from scenarios.stereo_follow.robot import Robot
from sim.render.pipeline import Capture
from sim.shaders.baked.shader import BakedLightShader
from sim.world import World
from trackers.types import CameraCommand

NOD_RAD, NOD_KEPT = np.deg2rad(0.12), 0.8
"""The robot shakes: standard deviation of nod and roll, and their autoregression coefficient."""
_NEAR_M = 1.5
_SHADOW_TEXELS = 1024


class StereoFollowEpisode(StereoStage):
    """See ``scenarios.scenario.Episode``."""

    _shader: BakedLightShader
    _objects: People

    def __init__(self, setup: Setup) -> None:
        kept = setup.kept
        building = None if kept is None else kept.content.building
        self.plan = plan = make_plan(setup.preset, setup.seed, closed_loop=setup.closed_loop, kept=building)
        preset, crowd = plan.preset, plan.crowd
        if kept is None:
            world = World()
            baked = build(world, plan.building)
        else:
            world, baked = kept.vacated(), kept.content.baked
        people = People(world, plan)
        self._shader = BakedLightShader(world, baked, shadow_texels=_SHADOW_TEXELS, panels_raised=False)
        shake = setup.rng("shake").normal(0.0, NOD_RAD, (preset.frame_count, 2))
        for frame in range(1, preset.frame_count):
            shake[frame] = NOD_KEPT * shake[frame - 1] + (1 - NOD_KEPT**2) ** 0.5 * shake[frame]
        self._shake = shake
        self._robot = Robot(plan.building.plan, crowd.robot_m[0], crowd.robot_heading_rad[0], preset.rate_hz)
        events = LightEvents(plan.places, plan.light.switched, preset.rate_hz)
        super().__init__(setup, people, events, has_odometry=preset.odometry)

    def map_of(self) -> Building:
        """Return the building."""
        return self.plan.building

    def _obey(self, command: CameraCommand) -> None:
        self._robot.drive(command)

    def _move_to(self, frame: int) -> None:
        self._objects.move_to(frame)
        set_light(self._shader, self.plan.light, frame)
        crowd = self.plan.crowd
        if not self.closed_loop:
            self._robot.place_m, self._robot.heading_rad = crowd.robot_m[frame], float(crowd.robot_heading_rad[frame])
        self._robot_place = self._robot.place_m, self._robot.heading_rad
        self._T_world_camera = camera_pose(*self._robot_place, *self._shake[frame])

    def _capture(self, frame: int) -> Capture[Any]:
        self._camera.right_is_lost = bool(self.plan.dropped[frame])
        return super()._capture(frame)

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        people, pose = self._objects, self._T_world_camera
        distance_m = np.linalg.norm((people.T_world_object[:, :3, 3] - pose[:3, 3])[:, :2], axis=1)
        is_close = (distance_m < _NEAR_M) & (np.arange(len(distance_m)) != TARGET)
        seen = labels if self._setup.covers_all else people.labels(self._camera.model, pose, capture, is_close)
        lux = illuminance_lx(self._shader, people.chests_m(), pose[:3, 3])
        return {
            **self._pair_truth(capture, self.plan.places[self._frame], lux),
            "occluder": labels.hidden_by,
            "near_person": bool((is_close & (seen.visible_fraction > 0)).any()),
        }
