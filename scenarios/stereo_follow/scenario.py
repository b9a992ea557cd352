"""The scenario ``stereo-follow``: a person among others, followed by a robot with a stereo camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from scenarios.kept_world import KeptWorld
from scenarios.scenario import Pictureless, RendererName, preset_of
from scenarios.stereo_follow.crowd import KINDS
from scenarios.stereo_follow.episode import StereoFollowEpisode
from scenarios.stereo_follow.lighting import LitBuilding, build
from scenarios.stereo_follow.pictureless.bank import StereoPictureless
from scenarios.stereo_follow.plan import building_of, make_plan
from scenarios.stereo_follow.presets import PRESETS, StereoFollow
from scenarios.stereo_follow.robot import ROBOT
from scenarios.stereo_follow.truth import PeopleTruth
from scenarios.truth import TruthExtent
from sim.rng import episode_seed
from sim.world import World
from trackers.types import Carrier


@dataclass(frozen=True)
class StereoFollowScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "stereo-follow-v2"
    summary: str = "a person among others, followed by a robot with a stereo camera from corridor to yard"
    start: str = "the first pair and the person's box in the left picture; the camera's settings; odometry"
    target: str = "target"
    truth: type[PeopleTruth] = PeopleTruth
    classes: Mapping[str, str] = field(default_factory=lambda: dict.fromkeys(KINDS, "person"))
    carrier: Carrier = ROBOT
    pictureless: Pictureless | None = field(default_factory=StereoPictureless)
    presets: dict[str, StereoFollow] = field(default_factory=lambda: dict(PRESETS))
    world_fields: tuple[str, ...] = ()

    def episode(
        self,
        preset: str | StereoFollow,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> StereoFollowEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands drive the robot; None = as in the preset.
            truth: ``target`` leaves out expensive fields that scores of following do not use, see ``Truth``.

        Raises:
            ValueError: for an unknown preset or renderer, or a negative seed.
        """
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        plan = make_plan(configuration, episode_seed(seed, self.id, 0), closed_loop=looped)
        return StereoFollowEpisode(plan, renderer, truth)

    def keep_world(self, preset: StereoFollow, seed: int) -> KeptWorld:
        """Build the building of the seed's episode, and its light; see ``KeepsWorlds``."""
        building = building_of(episode_seed(seed, self.id, 0))
        world = World()
        baked = build(world, building)
        return KeptWorld(world, len(world.bodies), LitBuilding(building, baked))

    def episode_in(
        self,
        kept: KeptWorld,
        preset: StereoFollow,
        seed: int,
        *,
        renderer: RendererName = "raster",
        truth: TruthExtent = "all",
    ) -> StereoFollowEpisode:
        """Build the seed's episode in another building: people, their paths and how the light changes; see
        ``KeepsWorlds``.
        """
        plan = make_plan(preset, episode_seed(seed, self.id, 0), closed_loop=True, kept=kept.content.building)
        return StereoFollowEpisode(plan, renderer, truth, kept)


STEREO_FOLLOW = StereoFollowScenario()
