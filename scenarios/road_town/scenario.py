"""The scenario ``road-town``: a car in a town, seen from a helicopter that loses it from view."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scenarios.road_town.episode import RoadTownEpisode
from scenarios.road_town.flight import HELICOPTER
from scenarios.road_town.pictureless.bank import RoadPictureless
from scenarios.road_town.plan import draw_layout
from scenarios.road_town.presets import ABLATIONS, PRESETS
from scenarios.road_town.town import build_town
from scenarios.road_town.truth import RoadTruth
from scenarios.scenario import KeptWorld, Scenario, Setup
from sim.meshes.vehicle import VEHICLES


def keep_town(setup: Setup) -> KeptWorld:
    """Build the town of an episode. Excursions of others there lead only where nothing stands."""
    layout = draw_layout(setup.preset, setup.seed)
    world = build_town(layout, setup.rng("town"))
    return KeptWorld(world, len(world.bodies), layout)


class _Vehicles(Mapping[str, str]):
    """All models of vehicles, also those registered later, as cars."""

    def __getitem__(self, model: str) -> str:
        if model not in VEHICLES:
            raise KeyError(model)
        return "car"

    def __iter__(self) -> Iterator[str]:
        return iter(VEHICLES)

    def __len__(self) -> int:
        return len(VEHICLES)


ROAD_TOWN = Scenario(
    id="road-town-v2",
    summary="a car in a town, seen from a helicopter that often loses it from view",
    start="the first picture and the car's box in it; measured ego pose where the preset has instruments",
    stage=RoadTownEpisode,
    presets=PRESETS | ABLATIONS,
    classes=_Vehicles(),
    carrier=HELICOPTER,
    truth=RoadTruth,
    pictureless=RoadPictureless(),
    new_world=keep_town,
    world_fields=("street_patterns", "extent_m", "traffic_side"),
)
