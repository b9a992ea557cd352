"""Planned but not rendered episodes as arrays, for pictureless envs."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Sequence
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
        scenario: catalogue id. preset: its configuration, but for what each episode has of its own.
        seeds: (E,) episode seeds.
        arrays: the plans by name, E first; see the scenario's ``Pictureless``.
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
        """Return the index of the episode with a seed. Raises ValueError if the bank does not hold it."""
        found = np.flatnonzero(self.seeds == seed)
        few = f"one of the {len(self.seeds)} seeds in the bank, {self.seeds[0]} to {self.seeds[-1]}"
        check("episode_seed", len(found) > 0, few, seed)
        return int(found[0])


def episode_bank(
    scenario: str, preset: Any, seeds: Iterable[int], cache: Path | None = None, *, own: Sequence[Any] = ()
) -> EpisodeBank:
    """Plan episodes, or read the plans of an earlier call from a folder; planning one takes a second to a few.

    Args:
        preset: configuration. cache: folder, created if missing; None: plans are not stored.
        own: the configuration of each episode, where they differ in other than ``Pictureless.fixed_fields``.

    Raises:
        ValueError: for a scenario or a preset without envs without pictures.
    """
    pictureless = pictureless_of(scenario)
    pictureless.check_playable(preset)
    wanted = np.array(list(seeds))
    good = len(wanted) > 0 and wanted.dtype.kind == "i" and (wanted >= 0).all()
    check("seeds", bool(good), "whole numbers >= 0, e.g. range(256)", wanted.tolist())
    planned: list[dict[str, NDArray[np.float64]]] = []
    for seed, each in zip(wanted, own or [preset] * len(wanted), strict=True):
        settings = {k: v for k, v in dataclasses.asdict(each).items() if k not in ("summary", "closed_loop")}
        key = hashlib.sha256(repr((scenario, pictureless.version, sorted(settings.items()))).encode()).hexdigest()[:16]
        path = None if cache is None else cache / f"{scenario}-{key}" / f"{seed}.npz"
        if path is not None and path.is_file():
            with np.load(path, allow_pickle=False) as stored:
                planned.append(dict(stored))
            continue
        planned.append(pictureless.arrays(each, episode_seed(int(seed), scenario, 0)))
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            # Atomic: an interrupted run leaves no partial file, and several processes may plan the same episode.
            with atomic_file(path) as file:
                np.savez(file, **planned[-1])  # type: ignore[arg-type]
    arrays = {name: np.ascontiguousarray(np.stack([plan[name] for plan in planned])) for name in planned[0]}
    return EpisodeBank(scenario, preset, wanted.astype(np.int64), arrays)


def pictureless_of(scenario: str) -> Pictureless:
    """Return a scenario's simulation without pictures. Raises ValueError if it has none."""
    pictureless = catalog.scenario(scenario).pictureless
    check("pictures", pictureless is not None, f"True, since {scenario} has no dynamics without pictures", False)
    assert pictureless is not None
    return pictureless


def is_playable(scenario: str, preset: Any) -> bool:
    """Return whether a configuration has envs without pictures."""
    pictureless = catalog.scenario(scenario).pictureless
    return pictureless is not None and pictureless.is_playable(preset)
