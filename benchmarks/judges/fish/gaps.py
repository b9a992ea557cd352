"""Gaps of true fish, the events of the suite ``fish``.

A *gap* of a fish is a stretch of frames on which it does not stand apart (``contact``). Gaps with less than
``APART_FRAMES`` frames between them are one gap; those without as many frames before and after are not judged.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
