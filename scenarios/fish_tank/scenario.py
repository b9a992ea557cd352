"""The scenario ``fish-tank-v1``: a shoal in a tank, seen from above through rippled water.

By Bullet's closest points no two fish stand deeper in one another than 2 cm at any of 120 instants of ``quick`` (seeds
0 to 19, ``python -m tests.scenarios.standing_in_one_another fish-tank quick``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from scenarios.fish_tank.episode import TARGET, FishTankEpisode
from scenarios.fish_tank.head import HEAD
from scenarios.fish_tank.presets import PRESETS, FishTank
from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import RendererName, preset_of
from scenarios.truth import TruthExtent
from sim.rng import episode_seed
from trackers.types import Carrier


@dataclass(frozen=True)
class FishTankScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "fish-tank-v1"
    summary: str = "a shoal in a tank, seen from above through rippled water"
    start: str = "pictures of the tank without fish; for trackers of one target, the box of one fish"
    target: str = TARGET
    truth: type[FishTruth] = FishTruth
    classes: Mapping[str, str] = field(default_factory=lambda: {"fish": "fish"})
    carrier: Carrier = HEAD
    pictureless: None = None
    presets: dict[str, FishTank] = field(default_factory=lambda: dict(PRESETS))

    def episode(
        self,
        preset: str | FishTank,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> FishTankEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands steer the second camera; None = as in the preset.
            truth: ``target`` leaves out expensive fields that scores of following do not use, see ``Truth``.

        Raises:
            ValueError: for an unknown preset or renderer, or a negative seed.
        """
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        return FishTankEpisode(configuration, episode_seed(seed, self.id, 0), renderer, looped, truth)


FISH_TANK = FishTankScenario()
