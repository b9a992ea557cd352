"""One episode of ``paper-sheet``, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scenarios.paper_sheet.sheet import SHEET_M, Rooms, SheetScene, illuminance_on_sheet_lx
from scenarios.scenario import Frame, RendererName
from scenarios.stage import Stage
from scenarios.stereo_follow.camera import camera_model, camera_pose, registers
from scenarios.stereo_follow.light_events import LightEvents
from scenarios.stereo_follow.odometry import Odometry
from scenarios.stereo_follow.rig import StereoPair, StereoRig
from scenarios.stereo_follow.truth import StereoTruth
from sim.jointed_labels import joined, seen_body
from sim.labels import amodal_box
from sim.rng import generator
from sim.shaders.lamps import LampShader
from trackers.types import CameraCommand, EgoPose, Start

_NO_IDS = np.empty(0, np.int64)
_SIZE_M = np.array([[0.0, *SHEET_M]])


@dataclass(frozen=True, slots=True)
class SheetMap:
    """The map of a sheet's world: its walls."""

    plan: Rooms


class SheetEpisode(Stage):
    """See ``scenarios.scenario.Episode``. The camera follows a set path.

    Truth holds the sheet alone. The sheet's origin is the middle of its lower edge, not a place on the ground, and its
    illuminance is the mean over its surface.
    """

    def __init__(self, scene: SheetScene, seed: int, renderer: RendererName) -> None:
        self._scene = scene
        self._pair = StereoRig(scene.world, scene.camera, renderer, seed)
        super().__init__(
            scene.world, self._pair, frame_count=scene.frame_count, rate_hz=scene.rate_hz, closed_loop=False
        )
        self._odometry = Odometry(generator(seed, "odometry"))
        self._events = LightEvents([scene.place] * scene.frame_count, [None] * scene.frame_count, scene.rate_hz)
        self._shape = joined([scene.sheet.mesh])
        self._move_to(0)
        self._first_box_xyxy = amodal_box(scene.camera, self._T_world_camera, scene.sheet.mesh, scene.T_world_sheet)

    @property
    def start(self) -> Start:
        """The sheet's box in the first left picture."""
        return Start(camera_model(self._scene.camera), box_xyxy=self._first_box_xyxy.copy())

    @property
    def _shader(self) -> LampShader:
        return self._scene.shader

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Hold the camera's exposure or white balance from now on, or let them follow the light again."""
        self._pair.hold(exposure=exposure, white_balance=white_balance)

    def map_of(self) -> SheetMap:
        """Return the map of the walls."""
        return SheetMap(self._scene.plan)

    def _obey(self, command: CameraCommand) -> None:
        raise NotImplementedError("paper-sheet has no closed loop")

    def _move_to(self, frame: int) -> None:
        self._scene.move_to(frame)
        self._T_world_camera = camera_pose(self._scene.place_m, self._scene.heading_rad)

    def _take(self, frame: int) -> Frame:
        scene, pose = self._scene, self._T_world_camera
        if scene.settling_steps:
            self._pair.settle(scene.shader, pose, scene.settling_steps)
        pair = self._pair.take_pair(scene.shader, pose, frame)
        truth = self._truth(frame, pair)
        ego = EgoPose(self._odometry.measure(scene.place_m, scene.heading_rad))
        return Frame(self._pair.observation(pair, truth.time_s, ego, is_lost=False), truth)

    def _truth(self, frame: int, pair: StereoPair) -> StereoTruth:
        scene, pose, left = self._scene, self._T_world_camera, pair.left
        T_world_sheet, instance_id = scene.T_world_sheet[None], scene.sheet.index
        seen = seen_body(self._shape, T_world_sheet, scene.camera, pose, left.instance_id, instance_id, hiders=_NO_IDS)
        lux = illuminance_on_sheet_lx(scene.shader, scene.T_world_sheet)
        return StereoTruth(
            **self._seen(
                left,
                T_world_object=T_world_sheet,
                size_m=_SIZE_M.copy(),
                box_xyxy=seen.box_xyxy[None],
                visible_fraction=np.array([seen.visible_fraction]),
            ),
            names=("target",),
            kinds=("sheet",),
            instance_id=np.array([instance_id]),
            speed_mps=np.array([scene.speed_mps]),
            T_world_right=pair.T_world_right,
            right_instance_map=pair.right.instance_id,
            right_depth_m=pair.right.depth_m,
            illuminance_lx=np.array([lux]),
            place=scene.place,
            light_event=self._events.follow(frame, left.picture, lux),
            registers=registers(left.picture.settings),
        )
