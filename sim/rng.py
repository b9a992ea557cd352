"""Named, independent random generators, all drawn from one episode seed.

All random numbers of an episode come from these generators, none from a default one. A new use of randomness gets a
new name, so that it changes no other stream.
"""

from __future__ import annotations

import hashlib

import numpy as np


def episode_seed(master_seed: int, scenario_id: str, episode_index: int) -> int:
    """Return the seed of one episode: a 63-bit hash of all three arguments.

    Args:
        master_seed: seed of the whole run, >= 0.
        scenario_id: catalogue id with its version, e.g. ``road-town-v2``.
        episode_index: place of the episode in the run, >= 0.

    Raises:
        ValueError: if a number is negative.
    """
    for name, value in (("master_seed", master_seed), ("episode_index", episode_index)):
        if value < 0:
            raise ValueError(f"{name}: expected a whole number >= 0, got {value}")
    digest = hashlib.sha256(f"{master_seed}/{scenario_id}/{episode_index}".encode()).digest()
    return int.from_bytes(digest[:8], "little") >> 1


def generator(seed: int, stream: str) -> np.random.Generator:
    """Return the generator of one named stream of an episode, e.g. ``generator(seed, "traffic")``."""
    key = int.from_bytes(hashlib.sha256(stream.encode()).digest()[:8], "little")
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, key))))
