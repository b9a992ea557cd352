"""One episode of ``stereo-follow`` whose target is a sheet of paper, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.paper_sheet.sheet import SHEET_M, Rooms, SheetScene, illuminance_on_sheet_lx
from scenarios.scenario import Frame, RendererName
from scenarios.stereo_follow.camera import camera_pose, registers
from scenarios.stereo_follow.light_events import LightEvents
from scenarios.stereo_follow.odometry import Odometry
from scenarios.stereo_follow.rig import StereoPair, StereoRig
from scenarios.stereo_follow.truth import PeopleTruth
from scenarios.visibility import Exits, centres_px, state_of
from sim.jointed_labels import joined, seen_body
from sim.labels import amodal_box
from sim.rng import generator
from sim.world import World
from trackers.types import CameraCommand, EgoPose

_NOBODY = np.empty(0, np.int64)
_SIZE_M = np.array([[0.0, *SHEET_M]])


@dataclass(frozen=True, slots=True)
class SheetMap:
    """What ``SheetEpisode.map_of`` knows: where the walls are."""

    plan: Rooms


class SheetEpisode:
    """See ``scenarios.scenario.Episode``. The camera goes its set path; the sheet alone is in truth, as its target."""

    def __init__(self, scene: SheetScene, seed: int, renderer: RendererName) -> None:
        self.frame_count, self.rate_hz, self.closed_loop = scene.frame_count, scene.rate_hz, False
        self._scene = scene
        self._rig = StereoRig(scene.world, scene.camera, renderer, seed)
        self._odometry = Odometry(generator(seed, "odometry"))
        self._events = LightEvents([scene.place] * scene.frame_count, [None] * scene.frame_count, scene.rate_hz)
        self._exits = Exits(scene.camera)
        self._shape = joined([scene.sheet.mesh])
        self._frame = -1
        self._move_to(0)
        self.target_box_xyxy = amodal_box(scene.camera, self._T_world_camera, scene.sheet.mesh, scene.T_world_sheet)

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame; see ``Episode.step``.

        Raises:
            ValueError: if a command is given.
            StopIteration: after the last frame.
        """
        frame = self._frame + 1
        if frame >= self.frame_count:
            raise StopIteration(f"episode: expected at most {self.frame_count} steps")
        if command is not None:
            raise ValueError("command: expected None, since this episode follows a set path, got a CameraCommand")
        self._move_to(frame)
        self._frame = frame
        scene, pose = self._scene, self._T_world_camera
        if scene.settling_steps:
            self._rig.settle(scene.shader, pose, scene.settling_steps)
        pair = self._rig.take(scene.shader, pose, frame)
        truth = self._truth(pair)
        ego = EgoPose(self._odometry.measure(scene.place_m, scene.heading_rad))
        return Frame(self._rig.observation(pair, truth.time_s, ego, is_lost=False), truth)

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Let the camera's exposure or white balance stay as they are from now on, or follow the light again."""
        self._rig.hold(exposure=exposure, white_balance=white_balance)

    def map_of(self) -> SheetMap:
        """Return where the walls are."""
        return SheetMap(self._scene.plan)

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high; see ``Episode.larger_view``."""
        return self._rig.larger_view(self._scene.shader, self._T_world_camera, scale)

    @property
    def world(self) -> World:
        """The bodies, where they are now; for other renderers to draw."""
        return self._scene.world

    def close(self) -> None:
        """Free the world."""
        self._scene.world.close()

    def _move_to(self, frame: int) -> None:
        self._scene.move_to(frame)
        self._T_world_camera = camera_pose(self._scene.place_m, self._scene.heading_rad)

    def _truth(self, pair: StereoPair) -> PeopleTruth:
        scene, pose, frame, left = self._scene, self._T_world_camera, self._frame, pair.left
        T_world_sheet, instance_id = scene.T_world_sheet.copy(), scene.sheet.index
        seen = seen_body(
            self._shape, T_world_sheet[None], scene.camera, pose, left.instance_id, instance_id, hiders=_NOBODY
        )
        state = state_of(scene.camera, seen.box_xyxy, seen.visible_fraction)
        side, frames_since_exit = self._exits.follow(state, seen.box_xyxy)
        used = left.picture.settings
        lux = illuminance_on_sheet_lx(scene.shader, T_world_sheet)
        return PeopleTruth(
            frame=frame,
            time_s=frame / self.rate_hz,
            T_world_camera=pose,
            target=0,
            names=("target",),
            kinds=("sheet",),
            T_world_object=T_world_sheet[None],
            size_m=_SIZE_M.copy(),
            speed_mps=np.array([scene.speed_mps]),
            position_px=centres_px(scene.camera, pose, T_world_sheet[None], _SIZE_M),
            box_xyxy=seen.box_xyxy[None],
            instance_id=np.array([instance_id]),
            visible_fraction=np.array([seen.visible_fraction]),
            state=state,
            side=side,
            frames_since_exit=frames_since_exit,
            instance_map=left.instance_id,
            depth_m=left.depth_m,
            exposure_s=used.exposure_s,
            gain=used.gain,
            T_world_right=pair.T_world_right,
            right_instance_map=pair.right.instance_id,
            right_depth_m=pair.right.depth_m,
            occluder=np.array([-1]),
            illuminance_lx=np.array([lux]),
            place=scene.place,
            light_event=self._events.follow(frame, left.picture, lux),
            near_person=False,
            registers=registers(used),
        )
