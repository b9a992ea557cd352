"""Gaps of true fish, the events of the suite ``fish``.

A *gap* of a fish is a stretch of frames on which it does not stand apart (``contact``). Gaps with less than
``APART_FRAMES`` frames between them are one gap; those without as many frames before and after are not judged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.suite import EventWords
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges.runs import runs

APART_FRAMES = 5
"""Fewer frames apart do not part two gaps."""


@dataclass(frozen=True, slots=True)
class FishGap:
    """A gap of one fish, an event.

    Attributes:
        index: in the episode. fish: index of the object.
        first_frame, length_frames: of the gap.
        fish_count: number of fish in it: this one and all that lay together with it.
        crosses: whether its centre line crossed another's.
    """

    index: int
    fish: int
    first_frame: int
    length_frames: int
    fish_count: int
    crosses: bool

    @property
    def end_frame(self) -> int:
        """The frame after its last one."""
        return self.first_frame + self.length_frames

    def attributes(self) -> dict[str, Any]:
        """See ``benchmarks.contract.judging.Event``; ``up_to_G``: of at most G frames."""
        return {
            "index": self.index,
            "kind": "gap",
            **asdict(self),
            "up_to_50": self.length_frames <= 50,
            "up_to_200": self.length_frames <= 200,
            "crosses_up_to_50": self.crosses and self.length_frames <= 50,
        }


def find_gaps(apart: NDArray[np.bool_], together_with: NDArray[np.bool_], crosses: NDArray[np.bool_]) -> list[FishGap]:
    """Return the gaps of an episode in order of time.

    Args:
        apart: (T, N) see ``contact.stands_apart``. together_with: (T, N, N) see ``contact.together``. crosses: (T, N).
    """
    found = []
    for fish, own in enumerate(apart.T):
        long = np.zeros_like(own)
        for first, end in runs(own):
            long[first:end] = end - first >= APART_FRAMES
        for first, end in runs(~long):
            if first > 0 and end < len(apart):
                others = together_with[first:end, fish].any(axis=0)
                crossed = bool(crosses[first:end, fish].any())
                found.append(FishGap(0, fish, first, end - first, 1 + int(others.sum()), crossed))
    found.sort(key=lambda gap: (gap.first_frame, gap.fish))
    return [replace(gap, index=index) for index, gap in enumerate(found)]


def _describe(events: Sequence[dict[str, Any]]) -> str:
    lengths = sorted(event["length_frames"] for event in events)
    if not lengths:
        return "no gaps"
    crossing = sum(event["crosses"] for event in events)
    return (
        f"{counted(len(lengths), 'gap')} of {lengths_text(lengths)}, half of them below "
        f"{lengths[len(lengths) // 2] + 1}; in {crossing} fish cross"
    )


EVENTS = EventWords(
    name="gaps",
    key="event",
    tests={
        "up to 10 frames": lambda event: bool(event["length_frames"] <= 10),
        "11 to 50 frames": lambda event: bool(10 < event["length_frames"] <= 50),
        "more than 50 frames": lambda event: bool(event["length_frames"] > 50),
        "fish cross": lambda event: bool(event["crosses"]),
        "no fish cross": lambda event: not event["crosses"],
        "two fish": lambda event: bool(event["fish_count"] <= 2),
        "three or more fish": lambda event: bool(event["fish_count"] > 2),
    },
    describe=_describe,
)
