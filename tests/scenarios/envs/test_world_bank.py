"""An env that keeps worlds: their order, and episodes equal to those in a world that is built for them."""

from __future__ import annotations

import weakref
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv, WorldBank
from scenarios.envs.truth_info import OWN_WORLD
from scenarios.scenario import KeptWorld
from sim.world import World
from tests.scenarios.envs.compared import assert_same

SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "road-town-v2": ("colour_pf", {"extent_m": 300.0}),
    "stereo-follow-v2": ("stereo_wb", {}),
}
"""Scene -> tracker and changes of the preset, for small worlds."""
STEPS = 4


@dataclass
class Keeper:
    """Builds empty worlds; ``open`` are the seeds of those that somebody still holds."""

    world_fields: tuple[str, ...] = ("size",)
    alive: weakref.WeakValueDictionary[int, World] = field(default_factory=weakref.WeakValueDictionary)
    built: list[int] = field(default_factory=list)

    def keep_world(self, preset: Any, seed: int) -> KeptWorld:
        self.built.append(seed)
        world = self.alive[seed] = World()
        return KeptWorld(world, 0, preset.size)

    @property
    def open(self) -> list[int]:
        return sorted(self.alive)


PRESET = SimpleNamespace(size=1)


def drawn(bank: WorldBank, seed: int, count: int) -> list[int]:
    rng = np.random.default_rng(seed)
    bank.begin()
    return [bank.draw(rng) for _ in range(count)]


@given(worlds=st.integers(1, 4), every=st.integers(1, 5), seed=st.integers(0, 99))
def test_a_new_world_comes_as_often_as_asked_and_only_the_latest_have_episodes(worlds, every, seed):
    seeds = drawn(WorldBank(Keeper(), worlds, every), seed, 40)
    for k in range(40):
        latest = seeds[: k + 1 : every][-worlds:]
        assert seeds[k] == latest[-1] if k % every == 0 else seeds[k] in latest
    assert all(0 <= each < 10_000 for each in seeds)


def test_the_order_begins_anew_with_a_seed():
    bank = WorldBank(Keeper(), 2, 3)
    first = drawn(bank, 7, 10)
    assert drawn(bank, 7, 10) == first
    assert drawn(bank, 8, 10) != first
    assert len(set(first)) == 4


def test_each_world_is_built_once_and_freed_when_it_cannot_come_again():
    keeper = Keeper()
    bank = WorldBank(keeper, 2, 3)
    rng = np.random.default_rng(0)
    for k in range(12):
        seed = bank.draw(rng)
        bank.tidy()
        assert bank.world(PRESET, seed) is bank.world(PRESET, seed)
        assert len(keeper.open) == (1 if k < 3 else 2)
        assert seed in keeper.open
    assert len(keeper.built) == len(set(keeper.built)) == 4
    bank.close()
    assert keeper.open == []


def test_a_world_is_built_again_if_asked_or_for_another_kind():
    keeper = Keeper()
    bank = WorldBank(keeper, 1, 9)
    seed = bank.draw(np.random.default_rng(0))
    one = bank.world(PRESET, seed)
    assert bank.world(SimpleNamespace(size=1, cars=3), seed) is one
    del one
    other = bank.world(SimpleNamespace(size=2), seed)
    assert other.content == 2
    assert bank.world(SimpleNamespace(size=2), seed, anew=True) is not other
    assert keeper.open == [seed]


def test_a_world_that_was_asked_for_is_freed_when_the_next_episode_needs_none():
    keeper = Keeper()
    bank = WorldBank(keeper, 1, 2)
    drawn_seed = bank.draw(np.random.default_rng(0))
    bank.world(PRESET, drawn_seed)
    bank.world(PRESET, 12_345)
    assert sorted(keeper.open) == sorted([drawn_seed, 12_345])
    bank.tidy()
    assert keeper.open == [drawn_seed]


def rollout(env: FollowEnv, **options: Any) -> tuple[Any, ...]:
    """Return the results of a few steps of one episode."""
    rng = np.random.default_rng(0)
    results = [env.reset(**options)]
    for _ in range(STEPS):
        results.append(env.step(rng.uniform(-1, 1, env.action_space.shape)))
    return tuple(results)


@pytest.mark.heavy
@pytest.mark.parametrize("scenario", SCENES)
def test_an_episode_in_a_used_world_is_the_one_in_a_world_built_for_it(scenario):
    """That an episode without a world of the bank is the catalogue's is tested in ``test_follow_env_worlds``."""
    tracker, changes = SCENES[scenario]
    keywords = {"preset": "quick", "changes": {"width_px": 84, "height_px": 84} | changes, "observation": "both"}
    env = FollowEnv(scenario, tracker=tracker, worlds=1, episodes_per_world=3, **keywords)
    first, second, third = (rollout(env, seed=5 if k == 0 else None) for k in range(3))
    # Back in the same world.
    assert_same(rollout(env, seed=5), first)
    seeds, others = ({name: each[0][1][name] for name in ("episode_seed", "world_seed")} for each in (third, second))
    assert seeds["world_seed"] == others["world_seed"] != OWN_WORLD
    assert seeds["episode_seed"] != others["episode_seed"]
    alone = FollowEnv(scenario, tracker=tracker, **keywords)
    assert_same(rollout(alone, options=seeds), third)
    alone.close()
    # An episode that is asked for is that one here too, and what comes after it is the same as ever.
    assert_same(rollout(env, options=others), second)
    assert_same(rollout(env), third)
    assert (second[0][0]["pixels"] != third[0][0]["pixels"]).any()
    env.close()


def test_the_scenes_of_this_test_are_all_that_keep_worlds():
    able = {name for name in catalog.names() if catalog.scenario(name).new_world is not None}
    assert {catalog.unversioned(name) for name in able} == {catalog.unversioned(name) for name in SCENES}
