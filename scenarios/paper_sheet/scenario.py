"""The scenario ``paper-sheet-v1``: a green sheet of paper before a stereo camera, as in paper B's experiments I and II.

Camera, rig, odometry, panels and light events are those of ``stereo-follow``: the same robot in other rooms.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from scenarios.paper_sheet.carried_sheet import CarriedSheet
from scenarios.paper_sheet.dimmed_sheet import DimmedSheet
from scenarios.paper_sheet.episode import SheetEpisode
from scenarios.scenario import Pictureless, RendererName, preset_of
from scenarios.stereo_follow.robot import ROBOT
from scenarios.stereo_follow.truth import StereoTruth
from scenarios.truth import TruthExtent
from sim.checks import check
from sim.rng import episode_seed
from trackers.types import Carrier

Preset = DimmedSheet | CarriedSheet

_SEEDED_AS = "stereo-follow-v1"
"""The presets once belonged to this scenario, which is deleted: seeds still derive from its id, so that the pictures
of published figures stay the same.
"""


@dataclass(frozen=True)
class PaperSheetScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "paper-sheet-v1"
    summary: str = "a green sheet of paper before a stereo camera, under light that changes"
    start: str = "the first pair and the sheet's box in the left picture; the camera's settings; odometry"
    target: str = "target"
    truth: type[StereoTruth] = StereoTruth
    classes: Mapping[str, str] = field(default_factory=lambda: {"sheet": "sheet"})
    carrier: Carrier = ROBOT
    pictureless: Pictureless | None = None
    presets: dict[str, Preset] = field(
        default_factory=lambda: {
            "paper-b1": DimmedSheet("the paper's first: a sheet on a wall, a picture at each of nine illuminances"),
            "paper-b2": CarriedSheet("the paper's second: a sheet carried before the camera through corridors"),
        }
    )

    def episode(
        self,
        preset: str | Preset,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> SheetEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: None or False, since the camera follows a set path.
            truth: both extents are the same, since the sheet is the only object.

        Raises:
            ValueError: for an unknown preset or renderer, a negative seed, or a closed loop.
        """
        check("closed_loop", not closed_loop, f"None or False, since {preset} follows a set path", closed_loop)
        own_seed = episode_seed(seed, _SEEDED_AS, 0)
        return SheetEpisode(preset_of(self, preset).scene(own_seed), own_seed, renderer)


PAPER_SHEET = PaperSheetScenario()
