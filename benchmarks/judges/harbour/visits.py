"""The visits of intruders: the events of the suite ``harbour``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.harbour.streaks import streaks

KINDS = ("person", "car", "boat")
SEEABLE = 5.0
"""Least contrast to noise of what is distinct from noise without doubt: the criterion of Rose (1948)."""


@dataclass(frozen=True, slots=True)
class Visit:
    """An intruder that is judged: at least half of it is seen in the watched volume on four frames running.

    Attributes:
        index: of the object. name, kind: of the object.
        first_frame, length_frames: from the first to the last frame on which it is judged.
        contrast_to_noise: the most that it has on four frames running.
        seeable: whether that is at least ``SEEABLE``.
    """

    index: int
    name: str
    kind: str
    first_frame: int
    length_frames: int
    contrast_to_noise: float
    seeable: bool

    def attributes(self) -> dict[str, Any]:
        """See ``Event``."""
        return asdict(self)


def find_visits(
    names: Sequence[str], kinds: Sequence[str], judged: NDArray[np.bool_], contrast: NDArray[np.float64]
) -> list[Visit]:
    """Return the visits, in order of the objects; ``judged`` and contrast to noise are (T, N)."""
    frame, index = np.nonzero(judged)
    found = streaks(frame, index, contrast[frame, index])
    visits = []
    for k, level in zip(found.key.tolist(), found.level.tolist(), strict=True):
        frames = np.flatnonzero(judged[:, k])
        first, length = int(frames[0]), int(frames[-1] - frames[0] + 1)
        visits.append(Visit(k, names[k], kinds[k], first, length, round(level, 2), level >= SEEABLE))
    return visits
