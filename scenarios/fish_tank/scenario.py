"""The scenario ``fish-tank-v1``: a shoal in a tank, seen from above through rippled water.

By Bullet's closest points no two fish stand deeper in one another than 2 cm at any of 120 instants of ``quick`` (seeds
0 to 19, ``python -m tests.scenarios.standing_in_one_another fish-tank quick``).
"""

from __future__ import annotations

from scenarios.fish_tank.episode import FishTankEpisode
from scenarios.fish_tank.head import HEAD
from scenarios.fish_tank.presets import PRESETS
from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import Scenario

FISH_TANK = Scenario(
    id="fish-tank-v1",
    summary="a shoal in a tank, seen from above through rippled water",
    start="pictures of the tank without fish; for trackers of one target, the box of one fish",
    stage=FishTankEpisode,
    presets=PRESETS,
    classes={"fish": "fish"},
    carrier=HEAD,
    truth=FishTruth,
    target="fish-0",
)
