"""Worlds that the episodes of a process share: to build a town or a building takes as long as hundreds of pictures."""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Hashable, Iterable, Mapping
from concurrent.futures import Future
from threading import Lock
from typing import Any

import numpy as np

from scenarios.scenario import KeptWorld, Scenario

MOST_BYTES = 1 << 30
"""Arrays of the worlds that a process keeps; what renderers make of them takes up to twice as much again."""


class WorldPool:
    """Builds each world once, and keeps those that were wanted last. Threads may share it."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        """``most_bytes``: size of all kept worlds together; the latest one is kept even if it is larger."""
        self._most_bytes = most_bytes
        self._lock = Lock()
        self._worlds: OrderedDict[Hashable, Future[tuple[KeptWorld, int]]] = OrderedDict()

    def world(self, scenario: Scenario[Any], preset: Any, seed: int) -> KeptWorld:
        """Return the world of a seed for episodes of a configuration, see ``Scenario.keep_world``."""
        key = scenario.id, scenario.world_kind(preset), seed
        with self._lock:
            is_new = key not in self._worlds
            promised = self._worlds.setdefault(key, Future())
            self._worlds.move_to_end(key)
        if is_new:
            try:
                kept = scenario.keep_world(preset, seed)
                promised.set_result((kept, array_bytes(kept)))
            except BaseException as error:
                with self._lock:
                    self._worlds.pop(key, None)
                promised.set_exception(error)
                raise
            self._let_go()
        # Another thread may still build it.
        return promised.result()[0]

    def clear(self) -> None:
        """Let go of all worlds; episodes that run in them keep theirs."""
        with self._lock:
            self._worlds.clear()

    def _let_go(self) -> None:
        """Let go of the worlds that were not wanted for the longest time."""
        with self._lock:
            sizes = {key: each.result()[1] for key, each in self._worlds.items() if each.done()}
            total = sum(sizes.values())
            for key, size in list(sizes.items())[:-1]:
                if total <= self._most_bytes:
                    return
                del self._worlds[key]
                total -= size


POOL = WorldPool()
"""The worlds of this process."""


def array_bytes(thing: Any) -> int:
    """Return the size of all arrays that a dataclass, a world or a collection holds, each counted once."""
    found: dict[int, int] = {}
    _count_arrays(thing, found)
    return sum(found.values())


def _count_arrays(thing: Any, found: dict[int, int]) -> None:
    if id(thing) in found or isinstance(thing, str | int | float | None):
        return
    found[id(thing)] = thing.nbytes if isinstance(thing, np.ndarray) else 0
    parts: Iterable[Any] = ()
    if dataclasses.is_dataclass(thing):
        parts = (getattr(thing, each.name) for each in dataclasses.fields(thing))
    elif isinstance(thing, Mapping):
        parts = thing.values()
    elif isinstance(thing, list | tuple):
        parts = thing
    elif hasattr(thing, "bodies"):
        parts = thing.bodies
    for part in parts:
        _count_arrays(part, found)
