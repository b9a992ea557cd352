"""The visits of intruders: the events of the suite ``harbour``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.suite import EventWords
from benchmarks.contract.text import counted
from benchmarks.judges.harbour.streaks import streaks

KINDS = ("person", "car", "boat")
SEEABLE = 5.0
"""Least contrast to noise of what can be told from noise without doubt: the criterion of Rose (1948)."""


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


def _describe(events: Sequence[dict[str, Any]]) -> str:
    if not events:
        return "no intruders"
    counts = Counter(event["kind"] for event in events)
    kinds = ", ".join(f"{counts[kind]} × {kind}" for kind in KINDS if counts[kind])
    hidden = sum(not event["seeable"] for event in events)
    return f"{counted(len(events), 'intruder')} ({kinds}); {hidden or 'none'} that nobody could see"


def _is(kind: str, event: dict[str, Any]) -> bool:
    return bool(event["kind"] == kind)


def _within(low: float, high: float, event: dict[str, Any]) -> bool:
    return bool(low <= event["contrast_to_noise"] < high)


EVENTS = EventWords(
    name="visits",
    key="event",
    tests={
        "cars": partial(_is, "car"),
        "boats": partial(_is, "boat"),
        "people": partial(_is, "person"),
        "contrast to noise 5 to 150": partial(_within, SEEABLE, 150.0),
        "contrast to noise 150 to 300": partial(_within, 150.0, 300.0),
        "contrast to noise 300 to 1000": partial(_within, 300.0, 1000.0),
        "contrast to noise from 1000": partial(_within, 1000.0, np.inf),
        "up to 60 s": lambda event: bool(event["length_frames"] <= 30),
        "longer than 60 s": lambda event: bool(event["length_frames"] > 30),
    },
    describe=_describe,
)
"""People have a contrast to noise of 75 to 950, mostly 150 to 300, cars and boats up to 5000."""
