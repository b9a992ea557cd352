"""The scenario ``road-town``: a car in a town, seen from a helicopter that loses it from view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from scenarios.kept_world import KeptWorld
from scenarios.road_town.episode import RoadTownEpisode
from scenarios.road_town.flight import HELICOPTER
from scenarios.road_town.pictureless.bank import RoadPictureless
from scenarios.road_town.plan import draw_layout, make_plan
from scenarios.road_town.presets import ABLATIONS, PRESETS, RoadTown
from scenarios.road_town.town import build_town
from scenarios.road_town.truth import RoadTruth
from scenarios.scenario import Pictureless, RendererName, preset_of
from scenarios.truth import TruthExtent
from sim.meshes.vehicle import VEHICLES
from sim.rng import episode_seed, generator
from trackers.types import Carrier


@dataclass(frozen=True)
class RoadTownScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "road-town-v2"
    summary: str = "a car in a town, seen from a helicopter that often loses it from view"
    start: str = "the first picture and the car's box in it; measured ego pose where the preset has instruments"
    target: str = "target"
    truth: type[RoadTruth] = RoadTruth
    carrier: Carrier = HELICOPTER
    pictureless: Pictureless | None = field(default_factory=RoadPictureless)
    presets: dict[str, RoadTown] = field(default_factory=lambda: PRESETS | ABLATIONS)
    world_fields: tuple[str, ...] = ("street_patterns", "extent_m", "traffic_side")

    @property
    def classes(self) -> Mapping[str, str]:
        """All models of vehicles, also those registered later; see ``Scenario``."""
        return dict.fromkeys(VEHICLES, "car")

    def episode(
        self,
        preset: str | RoadTown,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> RoadTownEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands steer the camera; None = as in the preset.
            truth: ``target`` leaves out expensive fields that scores of following do not use, see ``Truth``.

        Raises:
            ValueError: for an unknown preset or renderer, or a negative seed.
        """
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        plan = make_plan(configuration, episode_seed(seed, self.id, 0), closed_loop=looped)
        return RoadTownEpisode(plan, renderer, truth)

    def keep_world(self, preset: RoadTown, seed: int) -> KeptWorld:
        """Build the town of the seed's episode; see ``KeepsWorlds``."""
        seed = episode_seed(seed, self.id, 0)
        layout = draw_layout(preset, seed)
        world = build_town(layout, generator(seed, "town"))
        return KeptWorld(world, len(world.bodies), layout)

    def episode_in(
        self,
        kept: KeptWorld,
        preset: RoadTown,
        seed: int,
        *,
        renderer: RendererName = "raster",
        truth: TruthExtent = "all",
    ) -> RoadTownEpisode:
        """Build the seed's episode in another town: target, traffic, flight and day; see ``KeepsWorlds``.

        Excursions lead only where nothing stands.
        """
        plan = make_plan(preset, episode_seed(seed, self.id, 0), closed_loop=True, kept=kept.content)
        return RoadTownEpisode(plan, renderer, truth, kept)


ROAD_TOWN = RoadTownScenario()
