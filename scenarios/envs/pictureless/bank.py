"""Episodes decided but not drawn, as arrays: what a pictureless env plays through."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.scenario import Pictureless
from sim.checks import check
from sim.rng import episode_seed
from trackers.atomic_file import atomic_file


@dataclass(frozen=True, eq=False)
class EpisodeBank:
    """E episodes of T frames of one configuration of a scenario.

    Attributes:
        scenario: catalogue id. preset: its configuration.
        seeds: (E,) as ``reset(options={"episode_seed": ...})`` takes them.
        arrays: what was planned, by name, E first; see the scenario's ``Pictureless``.
    """

    scenario: str
    preset: Any
    seeds: NDArray[np.int64]
    arrays: dict[str, NDArray[np.float64]]

    @property
    def frame_count(self) -> int:
        """T."""
        return int(self.preset.frame_count)

    def index_of(self, seed: int) -> int:
        """Return which episode has a seed. Raises ValueError for one that is not in the bank."""
        found = np.flatnonzero(self.seeds == seed)
        few = f"one of the {len(self.seeds)} seeds in the bank, {self.seeds[0]} to {self.seeds[-1]}"
        check("episode_seed", len(found) > 0, few, seed)
        return int(found[0])


def episode_bank(scenario: str, preset: Any, seeds: Iterable[int], cache: Path | None = None) -> EpisodeBank:
    """Plan episodes, or read those of an earlier call from a folder; planning one takes about a second.

    Args:
        preset: configuration. cache: folder, made if it is not there; None: nothing is kept.

    Raises:
        ValueError: for a scenario, or a preset of it, that cannot be played without pictures.
    """
    playing = pictureless_of(scenario)
    check("preset", playing.is_playable(preset), "one with instruments (ego) or odometry", "neither")
    wanted = np.array(list(seeds), dtype=np.int64)
    check("seeds", len(wanted) > 0, "at least one", "none")
    if cache is None:
        fresh = [playing.arrays(preset, episode_seed(int(seed), scenario, 0)) for seed in wanted]
        return EpisodeBank(scenario, preset, wanted, _stacked(fresh))
    settings = {k: v for k, v in dataclasses.asdict(preset).items() if k not in ("summary", "closed_loop")}
    key = hashlib.sha256(repr((scenario, playing.version, sorted(settings.items()))).encode()).hexdigest()[:16]
    folder = cache / f"{scenario}-{key}"
    folder.mkdir(parents=True, exist_ok=True)
    planned: list[dict[str, Any]] = []
    for seed in wanted:
        path = folder / f"{seed}.npz"
        if path.is_file():
            with np.load(path, allow_pickle=False) as stored:
                planned.append({name: stored[name] for name in stored.files})
            continue
        planned.append(playing.arrays(preset, episode_seed(int(seed), scenario, 0)))
        # Whoever is stopped half way leaves no file that looks whole; several may plan the same episode at a time.
        with atomic_file(path) as file:
            np.savez(file, **planned[-1])
    return EpisodeBank(scenario, preset, wanted, _stacked(planned))


def pictureless_of(scenario: str) -> Pictureless:
    """Return how a scenario is played without pictures. Raises ValueError for one that cannot be."""
    playing = catalog.scenario(scenario).pictureless
    check("scenario", playing is not None, "one that can be played without pictures", repr(scenario))
    assert playing is not None
    return playing


def is_playable(scenario: str, preset: Any) -> bool:
    """Return whether there are envs without pictures of a configuration."""
    playing = catalog.scenario(scenario).pictureless
    return playing is not None and playing.is_playable(preset)


def _stacked(planned: list[dict[str, NDArray[np.float64]]]) -> dict[str, NDArray[np.float64]]:
    return {name: np.ascontiguousarray(np.stack([each[name] for each in planned])) for name in planned[0]}
