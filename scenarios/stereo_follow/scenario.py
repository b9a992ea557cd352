"""The scenario ``stereo-follow-v1``: a person among others, followed by a robot with a stereo camera."""

from __future__ import annotations

from dataclasses import dataclass, field

from scenarios.paper_sheet.carried_sheet import CarriedSheet
from scenarios.paper_sheet.dimmed_sheet import DimmedSheet
from scenarios.paper_sheet.episode import SheetEpisode
from scenarios.scenario import Pictureless, RendererName, preset_of
from scenarios.stereo_follow.episode import StereoFollowEpisode
from scenarios.stereo_follow.pictureless.bank import StereoPictureless
from scenarios.stereo_follow.plan import make_plan
from scenarios.stereo_follow.presets import PRESETS, StereoFollow
from scenarios.stereo_follow.robot import ROBOT
from scenarios.truth import TruthExtent
from sim.rng import episode_seed
from trackers.types import Carrier

Preset = StereoFollow | DimmedSheet | CarriedSheet

_PAPER: dict[str, Preset] = {
    "paper-b1": DimmedSheet("the paper's first: a green sheet on a wall, a picture at each of nine illuminances"),
    "paper-b2": CarriedSheet("the paper's second: a green sheet carried before the camera through corridors"),
}
"""Experiments on the camera alone: their target is no person."""


@dataclass(frozen=True)
class StereoFollowScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "stereo-follow-v1"
    summary: str = "a person among others, followed by a robot with a stereo camera from corridor to yard"
    start: str = "the first pair and the person's box in the left picture; the camera's settings; odometry"
    target: str = "target"
    carrier: Carrier = ROBOT
    pictureless: Pictureless | None = field(default_factory=StereoPictureless)
    presets: dict[str, Preset] = field(default_factory=lambda: {**PRESETS, **_PAPER})

    def episode(
        self,
        preset: str | Preset,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> StereoFollowEpisode | SheetEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands drive the robot; None = as the preset says.
            truth: ``target`` leaves out what takes long and following does not ask for, see ``Truth``; where a sheet is
                the target, it is all that there is.

        Raises:
            ValueError: for an unknown preset or renderer, a negative seed, or a closed loop about a sheet.
        """
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        own_seed = episode_seed(seed, self.id, 0)
        if not isinstance(configuration, StereoFollow):
            if looped:
                raise ValueError(f"closed_loop: expected None or False, since {preset} follows a set path, got True")
            return SheetEpisode(configuration.scene(own_seed), own_seed, renderer)
        plan = make_plan(configuration, own_seed, closed_loop=looped)
        return StereoFollowEpisode(plan, renderer, truth)


STEREO_FOLLOW = StereoFollowScenario()
