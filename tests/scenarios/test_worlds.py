"""A pool of worlds, and episodes in them equal to those in a world that is built for them."""

from __future__ import annotations

import gc
import threading
import time
import weakref
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios import catalog, worlds
from scenarios.envs.follow_env import FollowEnv
from scenarios.scenario import KeptWorld
from scenarios.worlds import WorldPool, array_bytes
from sim.world import World
from tests.scenarios.envs.compared import assert_same
from tests.sim.squares import square

SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "road-town-v2": ("colour_pf", {"extent_m": 300.0}),
    "stereo-follow-v2": ("stereo_wb", {}),
}
"""Scene -> tracker and changes of the preset, for small worlds."""
STEPS = 4
BYTES = 1000


@dataclass
class Keeper:
    """Builds empty worlds; ``open`` are the seeds of those that somebody still holds."""

    id: str = "keeper-v1"
    alive: weakref.WeakValueDictionary[int, World] = field(default_factory=weakref.WeakValueDictionary)
    built: list[int] = field(default_factory=list)
    wait_s: float = 0.0

    def world_kind(self, preset: Any) -> int:
        return int(preset.size)

    def keep_world(self, preset: Any, seed: int) -> KeptWorld:
        time.sleep(self.wait_s)
        self.built.append(seed)
        world = self.alive[seed] = World()
        return KeptWorld(world, (preset.size, np.zeros(BYTES, np.uint8)))

    @property
    def open(self) -> list[int]:
        gc.collect()
        return sorted(self.alive)


PRESET = SimpleNamespace(size=1)


@pytest.fixture(scope="module", autouse=True)
def _only_what_is_new_is_collected() -> Iterator[None]:
    """Late in a run of all tests the collector would search for seconds, hundreds of times."""
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.fixture
def fresh_pool(monkeypatch: pytest.MonkeyPatch) -> Iterator[WorldPool]:
    """Replace the pool of this process."""
    pool = WorldPool()
    monkeypatch.setattr("scenarios.envs.follow_env.POOL", pool)
    yield pool
    pool.clear()


@given(wanted=st.lists(st.integers(0, 5), min_size=1, max_size=30), most=st.integers(0, 4))
def test_the_worlds_that_were_wanted_last_are_kept(wanted: list[int], most: int) -> None:
    keeper: Any = Keeper()
    pool, order = WorldPool(most * BYTES), []
    for seed in wanted:
        is_kept = seed in order
        built = len(keeper.built)
        pool.world(keeper, PRESET, seed)
        assert (len(keeper.built) == built) == is_kept
        order = [other for other in order if other != seed] + [seed]
        order = order[-max(most, 1) :]
    assert keeper.open == sorted(order)
    pool.clear()
    assert keeper.open == []


def test_worlds_of_another_scenario_kind_or_seed_are_others() -> None:
    one, two = Keeper(), Keeper("other-v1")
    pool, large = WorldPool(), SimpleNamespace(size=2)
    calls: list[Any] = [(one, PRESET, 3), (two, PRESET, 3), (one, large, 3), (one, PRESET, 4)]
    made = [pool.world(*call) for call in calls]
    assert len({id(each) for each in made}) == 4
    assert all(pool.world(*call) is each for call, each in zip(calls, made, strict=True))
    assert pool.world(calls[0][0], SimpleNamespace(size=1, cars=3), 3) is made[0]


def test_threads_that_want_a_world_at_the_same_time_get_one() -> None:
    keeper: Any = Keeper(wait_s=0.05)
    pool = WorldPool()
    with ThreadPoolExecutor(4) as threads:
        made = list(threads.map(lambda k: pool.world(keeper, PRESET, k % 2), range(8)))
    assert sorted(keeper.built) == [0, 1]
    assert {id(each) for each in made} == {id(made[0]), id(made[1])}


def test_a_world_that_could_not_be_built_is_tried_again() -> None:
    class Failing(Keeper):
        def keep_world(self, preset: Any, seed: int) -> KeptWorld:
            if not self.built:
                self.built.append(seed)
                raise MemoryError("full")
            return super().keep_world(preset, seed)

    keeper: Any = Failing()
    pool = WorldPool()
    with pytest.raises(MemoryError, match="full"):
        pool.world(keeper, PRESET, 1)
    assert pool.world(keeper, PRESET, 1) is pool.world(keeper, PRESET, 1)
    assert keeper.built == [1, 1]


def test_arrays_are_counted_once_wherever_they_are() -> None:
    world, mesh = World(), square(1.0, 0)
    for k in range(3):
        world.add(mesh, np.eye(4), name=f"{k}", category="kerb")
    own = (mesh.vertices_m, mesh.normals, mesh.uv, mesh.faces, mesh.texture.rgb)
    assert array_bytes(KeptWorld(world, {"more": [np.zeros(5)]})) == sum(each.nbytes for each in own) + 40


def rollout(env: FollowEnv, steps: int = STEPS, **options: Any) -> tuple[Any, ...]:
    """Return the results of a few steps of one episode."""
    rng = np.random.default_rng(0)
    results = [env.reset(**options)]
    for _ in range(steps):
        results.append(env.step(rng.uniform(-1, 1, env.action_space.shape)))
    return tuple(results)


def keywords(scenario: str) -> dict[str, Any]:
    tracker, changes = SCENES[scenario]
    changes = {"width_px": 84, "height_px": 84} | changes
    common = {"preset": "quick", "changes": changes, "observation": "both", "worlds": 2}
    return {"scenario": scenario, "tracker": tracker} | common


@pytest.mark.heavy
@pytest.mark.parametrize("scenario", SCENES)
def test_a_seed_names_one_episode_whatever_came_before_and_beside_it(scenario: str, fresh_pool: WorldPool) -> None:
    with closing(FollowEnv(**keywords(scenario))) as first, closing(FollowEnv(**keywords(scenario))) as second:
        expected = {seed: rollout(first, options={"episode_seed": seed}) for seed in (4, 6, 7)}
        assert [expected[seed][0][1]["world_seed"] for seed in (4, 6, 7)] == [0, 0, 1]
        assert (expected[4][0][0]["pixels"] != expected[6][0][0]["pixels"]).any()
        # Two envs in one world, step by step.
        rngs, results = [np.random.default_rng(0) for _ in range(2)], []
        results.append([env.reset(options={"episode_seed": seed}) for env, seed in ((first, 4), (second, 6))])
        for _ in range(STEPS):
            actions = [rng.uniform(-1, 1, first.action_space.shape) for rng in rngs]
            results.append([env.step(action) for env, action in zip((first, second), actions, strict=True)])
        assert_same(tuple(one for one, _ in results), expected[4])
        assert_same(tuple(two for _, two in results), expected[6])
        # In a world that is built for it.
        fresh_pool.clear()
        assert_same(rollout(second, options={"episode_seed": 6, "world_seed": 0}), expected[6])
        # In its own.
        own = rollout(second, options={"episode_seed": 6, "world_seed": -1})
    with closing(FollowEnv(**{**keywords(scenario), "worlds": 0})) as alone:
        assert_same(rollout(alone, options={"episode_seed": 6}), own)
    assert (own[0][0]["pixels"] != expected[6][0][0]["pixels"]).any()


@pytest.mark.heavy
@pytest.mark.parametrize("scenario", SCENES)
def test_envs_in_threads_do_not_disturb_each_other(scenario: str, fresh_pool: WorldPool) -> None:
    seeds = ((4, 6, 7), (6, 4, 5))
    with closing(FollowEnv(**keywords(scenario))) as env:
        expected = {seed: rollout(env, options={"episode_seed": seed}) for seed in range(4, 8)}
    fresh_pool.clear()
    together = threading.Barrier(2)

    def rollouts(of: tuple[int, ...]) -> list[tuple[Any, ...]]:
        with closing(FollowEnv(**keywords(scenario))) as env:
            together.wait()
            return [rollout(env, options={"episode_seed": seed}) for seed in of]

    with ThreadPoolExecutor(2) as threads:
        for of, results in zip(seeds, threads.map(rollouts, seeds), strict=True):
            for seed, each in zip(of, results, strict=True):
                assert_same(each, expected[seed])


def test_the_scenes_of_this_test_are_all_that_keep_worlds() -> None:
    able = {name for name in catalog.names() if catalog.scenario(name).new_world is not None}
    assert {catalog.unversioned(name) for name in able} == {catalog.unversioned(name) for name in SCENES}
    assert worlds.POOL is not None
