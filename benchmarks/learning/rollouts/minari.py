"""Writes rollouts as a Minari data set by Minari's own storage (HDF5).

What is privileged is ``infos`` there. ``options`` of an episode are those of ``reset`` that bring it again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import minari
from minari.data_collector import EpisodeBuffer
from minari.dataset.minari_storage import MinariStorage

from benchmarks.learning.rollouts.card import dataset_id
from benchmarks.learning.rollouts.recording import PRIVILEGED, EpisodeFile, options_of
from benchmarks.learning.rollouts.request import Rollouts


def write_minari(rollouts: Rollouts, episodes: Sequence[EpisodeFile], folder: Path) -> None:
    """Write recorded episodes into a folder that is a root of Minari's (``MINARI_DATASETS_PATH``)."""
    env = rollouts.make()
    try:
        name = dataset_id(rollouts)
        place = folder / name / "data"
        place.mkdir(parents=True)
        # Pictures as they are, not as JPEG, so that a policy sees what it would see in the env.
        storage = MinariStorage.new(place, env.observation_space, env.action_space, env.spec, jpeg_encoding=False)
        told = {"dataset_id": name, "minari_version": minari.__version__, "algorithm_name": rollouts.controller}
        storage.update_metadata(told)
        storage.update_episodes(_buffers(rollouts, episodes))
    finally:
        env.close()


def _buffers(rollouts: Rollouts, episodes: Sequence[EpisodeFile]) -> Iterator[EpisodeBuffer]:
    for episode in episodes:
        observations: Any = episode.numbers("observation.track")
        if rollouts.pictures != "none":
            observations = {"pixels": episode.pictures(), "track": observations}
        names = [name for name in episode.names if name.startswith(PRIVILEGED)]
        yield EpisodeBuffer(
            options=options_of(episode.seed),
            observations=observations,
            actions=episode.numbers("action"),  # type: ignore[arg-type]
            rewards=episode.numbers("reward"),  # type: ignore[arg-type]
            terminations=episode.numbers("terminated"),  # type: ignore[arg-type]
            truncations=episode.numbers("truncated"),  # type: ignore[arg-type]
            infos={name.removeprefix(PRIVILEGED): episode.numbers(name) for name in names},
        )
