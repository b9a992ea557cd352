"""The scenario ``paper-sheet-v1``: a green sheet of paper before a stereo camera, as in paper B's experiments I and II.

Camera, rig, odometry, panels and light events are those of ``stereo-follow``: the same robot in other rooms.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.objects import JointedObjects, Labels
from scenarios.paper_sheet.carried_sheet import CarriedSheet
from scenarios.paper_sheet.dimmed_sheet import DimmedSheet
from scenarios.paper_sheet.sheet import SHEET_M, SheetScene, illuminance_on_sheet_lx
from scenarios.scenario import Scenario, Setup
from scenarios.stereo_follow.camera import camera_pose
from scenarios.stereo_follow.rig import LightEvents, StereoStage
from scenarios.stereo_follow.robot import ROBOT
from scenarios.stereo_follow.truth import StereoTruth
from sim.checks import check
from sim.render.pipeline import Capture


class SheetEpisode(StereoStage):
    """See ``scenarios.scenario.Episode``. The camera follows a set path.

    Truth holds the sheet alone. The sheet's origin is the middle of its lower edge, not a place on the ground, and its
    illuminance is the mean over its surface.
    """

    _objects: JointedObjects

    def __init__(self, setup: Setup) -> None:
        expected = "None or False, since the camera follows a set path"
        check("closed_loop", not setup.closed_loop, expected, setup.closed_loop)
        self._scene: SheetScene = setup.preset.scene(setup.seed)
        scene = self._scene
        frames, rate_hz = setup.preset.frame_count, setup.preset.rate_hz
        super().__init__(
            setup,
            JointedObjects(scene.world, ["target"], ["sheet"], [[scene.sheet]], np.array([[0.0, *SHEET_M]])),
            LightEvents([scene.place] * frames, [None] * frames, rate_hz),
        )

    def hold(self, *, exposure: bool, white_balance: bool) -> None:
        """Hold the camera's exposure or white balance from now on, or let them follow the light again."""
        self._camera.hold(exposure=exposure, white_balance=white_balance)

    def map_of(self) -> SheetScene:
        """Return the world, which has a ``plan`` of its walls."""
        return self._scene

    def _move_to(self, frame: int) -> None:
        scene, sheet = self._scene, self._objects
        scene.move_to(frame)
        sheet.T_world_object, sheet.speed_mps = scene.T_world_sheet[None], np.array([scene.speed_mps])
        sheet.part_poses = [sheet.T_world_object]
        self._shader = scene.shader
        self._robot_place = scene.place_m, scene.heading_rad
        self._T_world_camera = camera_pose(*self._robot_place)

    def _capture(self, frame: int) -> Capture[Any]:
        if self._scene.settling_steps:
            self._camera.settle(self._shader, self._T_world_camera, self._scene.settling_steps)
        return super()._capture(frame)

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        lux = illuminance_on_sheet_lx(self._scene.shader, self._scene.T_world_sheet)
        return self._pair_truth(capture, self._scene.place, np.array([lux]))


_SEEDED_AS = "stereo-follow-v1"
"""The presets once belonged to this scenario, which is deleted: seeds still derive from its id, so that the pictures
of published figures stay the same.
"""
PAPER_SHEET = Scenario(
    id="paper-sheet-v1",
    summary="a green sheet of paper before a stereo camera, under light that changes",
    start="the first pair and the sheet's box in the left picture; the camera's settings; odometry",
    stage=SheetEpisode,
    presets={
        "paper-b1": DimmedSheet("the paper's first: a sheet on a wall, a picture at each of nine illuminances"),
        "paper-b2": CarriedSheet("the paper's second: a sheet carried before the camera through corridors"),
    },
    classes={"sheet": "sheet"},
    carrier=ROBOT,
    truth=StereoTruth,
    seeded_as=_SEEDED_AS,
)
