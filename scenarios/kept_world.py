"""Worlds that are kept and used again: several episodes take place in one town or building, one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from scenarios.scenario import Episode, RendererName
from scenarios.truth import TruthExtent
from sim.world import World


@dataclass(frozen=True, eq=False)
class KeptWorld:
    """A world with its fixed bodies.

    Attributes:
        world: with the bodies of the latest episode, too.
        fixed: number of bodies that every episode has.
        content: what the scenario drew these from, e.g. a town's layout.
    """

    world: World
    fixed: int
    content: Any

    def vacated(self) -> World:
        """Return the world with its fixed bodies alone; the episode before is over then."""
        self.world.remove_after(self.fixed)
        return self.world


@runtime_checkable
class KeepsWorlds(Protocol):
    """A ``Scenario`` whose worlds may be kept.

    Attributes:
        world_fields: fields of a preset that decide what its worlds are; they have the same values in a world and in
            every episode there.
    """

    @property
    def world_fields(self) -> tuple[str, ...]: ...

    def keep_world(self, preset: Any, seed: int) -> KeptWorld:
        """Build the world of the seed's episode, without the episode."""
        ...

    def episode_in(
        self, kept: KeptWorld, preset: Any, seed: int, *, renderer: RendererName = "raster", truth: TruthExtent = "all"
    ) -> Episode:
        """Build the seed's episode, in closed loop, in another seed's world.

        It is over when another one begins there.
        """
        ...
