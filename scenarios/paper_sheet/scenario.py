"""The scenario ``paper-sheet-v1``: a green sheet of paper before a stereo camera, as in paper B's experiments I and II.

Camera, rig, odometry, panels and light events are those of ``stereo-follow``: the same robot in other rooms.
"""

from __future__ import annotations

from scenarios.paper_sheet.carried_sheet import CarriedSheet
from scenarios.paper_sheet.dimmed_sheet import DimmedSheet
from scenarios.paper_sheet.episode import SheetEpisode
from scenarios.scenario import Scenario
from scenarios.stereo_follow.robot import ROBOT
from scenarios.stereo_follow.truth import StereoTruth

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
