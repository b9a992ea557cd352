"""A scenario supplies its simulation without pictures; the env names no scenario."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenarios import catalog, envs
from scenarios.envs.pictureless.bank import episode_bank, is_playable
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.vectors import follow_vector_env
from scenarios.road_town.pictureless.bank import RoadPictureless
from scenarios.road_town.pictureless.world import RoadWorld
from scenarios.road_town.scenario import ROAD_TOWN
from tests.scenarios.envs.pictureless.hand_made import PRESET, SETTINGS, bank, model
from trackers.types import Carrier, CommandAxis

BALLOON = Carrier("balloon", (CommandAxis("climb_mps", 2.0, 8.0),), "down")
SCENE_WORDS = {"road", "town", "stereo", "sheet", "helicopter", "robot"}


class Drifting(RoadWorld):
    """Moves north with the wind, independent of commands."""

    def move(self, states: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        super().move(states, wanted, waiting, sightings, rng)
        states["place_m"][:] = 0.0
        states["place_m"][:, 1] = states["frame"]


class BalloonPictureless(RoadPictureless):
    """The town's plans with another carrier."""

    def world(self, *arguments: Any) -> Drifting:
        return Drifting(*arguments)


BALLOON_TOWN = replace(ROAD_TOWN, id="balloon-town-v1", carrier=BALLOON, pictureless=BalloonPictureless())
SEEN_ALONE = replace(ROAD_TOWN, id="seen-alone-v1", pictureless=None)


@pytest.fixture
def _known(monkeypatch: pytest.MonkeyPatch) -> None:
    more = [
        catalog.Entry(f"{name}-v1", f"{__name__}:{place}")
        for name, place in (("balloon-town", "BALLOON_TOWN"), ("seen-alone", "SEEN_ALONE"))
    ]
    monkeypatch.setattr(catalog, "_ENTRIES", (*catalog._ENTRIES, *more))


@pytest.mark.heavy
@pytest.mark.usefixtures("_known")
def test_what_looks_down_moves_as_its_own_scenario_says() -> None:
    arguments = {**SETTINGS, "scenario": BALLOON_TOWN.id, "bank": replace(bank(), scenario=BALLOON_TOWN.id)}
    made = PicturelessVectorEnv(3, **arguments, model=model(scenario=BALLOON_TOWN.id))
    assert made.action_space.shape == (3, 1)
    made.reset(seed=0)
    for _ in range(5):
        made.step(np.ones((3, 1)))
    np.testing.assert_array_equal(made.states["place_m"], np.tile([0.0, 5.0, 0.0], (3, 1)))


@pytest.mark.usefixtures("_known")
def test_a_scenario_that_is_not_played_without_pictures_is_refused() -> None:
    assert is_playable(BALLOON_TOWN.id, PRESET)
    assert not is_playable(SEEN_ALONE.id, PRESET)
    with pytest.raises(ValueError, match="pictures: expected True, since seen-al"):
        episode_bank(SEEN_ALONE.id, PRESET, [1])


def test_envs_name_no_scenario_and_no_carrier() -> None:
    for path in Path(envs.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [value for _, value in ast.iter_fields(node) if isinstance(value, str)]
            words = set("_".join(names).replace("-", "_").replace(".", "_").replace(" ", "_").lower().split("_"))
            assert not words & SCENE_WORDS, f"{path}:{getattr(node, 'lineno', 0)}: {names}"


@pytest.mark.usefixtures("_known")
def test_an_env_with_pictures_only_names_the_keyword_that_it_refuses() -> None:
    with pytest.raises(ValueError, match=r"pictures: expected True, since seen-alone-v1 has no dynamics .*, got False"):
        follow_vector_env(2, scenario=SEEN_ALONE.id, tracker="mosaic_graph_pf", pictures=False)
