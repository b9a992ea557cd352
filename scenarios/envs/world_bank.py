"""The worlds that an env keeps."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from scenarios.scenario import KeptWorld, Scenario

DEVELOPMENT_SEEDS = 10_000
"""Drawn seeds of episodes and worlds lie below this number; only options of ``reset`` select others."""


class WorldBank:
    """Chooses a world for each episode, and keeps those that were built.

    Every ``episodes_per_world`` episodes a new world takes the place of the oldest of ``worlds``, and has the episode;
    the others have one of the kept worlds each, drawn at random. The choice depends on the generator and the number
    of episodes since ``begin`` alone.
    """

    def __init__(self, scenario: Scenario, worlds: int, episodes_per_world: int) -> None:
        self._scenario, self._episodes_per_world = scenario, episodes_per_world
        self._seeds: deque[int] = deque(maxlen=worlds)
        self._episodes = 0
        self._built: dict[int, tuple[tuple[Any, ...], KeptWorld]] = {}

    def begin(self) -> None:
        """Choose as if there had been no episode."""
        self._seeds.clear()
        self._episodes = 0

    def draw(self, rng: np.random.Generator) -> int:
        """Return the seed of the next episode's world."""
        is_new = self._episodes % self._episodes_per_world == 0
        self._episodes += 1
        if is_new:
            self._seeds.append(int(rng.integers(DEVELOPMENT_SEEDS)))
            return self._seeds[-1]
        return self._seeds[int(rng.integers(len(self._seeds)))]

    def world(self, preset: Any, seed: int, *, anew: bool = False) -> KeptWorld:
        """Return the world with a seed for an episode of a configuration.

        Args:
            anew: build it also if it is kept.
        """
        fields = tuple(getattr(preset, name) for name in self._scenario.world_fields)
        if seed in self._built and (anew or self._built[seed][0] != fields):
            del self._built[seed]
        if seed not in self._built:
            self._built[seed] = fields, self._scenario.keep_world(preset, seed)
        return self._built[seed][1]

    def tidy(self) -> None:
        """Let go of the worlds that no drawn episode can have any more."""
        for other in set(self._built) - set(self._seeds):
            del self._built[other]

    def close(self) -> None:
        """Let go of all worlds."""
        self._built.clear()
