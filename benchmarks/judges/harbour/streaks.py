"""Runs of four frames: what is tracked four times running, and up to which confidence."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RUNNING = 4
"""Frames running on which an intruder has to be tracked, or nothing, to count as found, or as an alarm (paper D)."""


class Streaks(NamedTuple):
    """The keys with a run, each once, sorted.

    Attributes:
        key: (U,). level: (U,) highest threshold at which it has a run: of every four frames running the least value,
            of these the largest. begins: (U,) frame on which its first run begins, at any value.
    """

    key: NDArray[np.int64]
    level: NDArray[np.float64]
    begins: NDArray[np.int64]


def streaks(frame: NDArray[np.int64], key: NDArray[np.int64], value: NDArray[np.float64]) -> Streaks:
    """Return the runs of ``RUNNING`` frames without a pause of each key, from rows (R,); a key has one row a frame."""
    order = np.lexsort((frame, key))
    frame, key, value = frame[order], key[order], value[order]
    last = RUNNING - 1
    end = max(len(key) - last, 0)
    whole = (key[:end] == key[last:]) & (frame[last:] - frame[:end] == last)
    begins = np.flatnonzero(whole)
    least = np.min([value[begins + k] for k in range(RUNNING)], axis=0)
    keys, place = np.unique(key[begins], return_index=True)
    level = np.maximum.reduceat(least, place) if len(keys) else least
    return Streaks(keys, level, frame[begins[place]])


def highest(of: NDArray[np.int64], level: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return (count,) the largest level of each number from 0; -inf for one without."""
    best = np.full(count, -np.inf)
    np.maximum.at(best, of, level)
    return best
