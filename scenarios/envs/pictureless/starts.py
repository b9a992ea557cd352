"""Beginnings in the middle of an episode, a little before the target is about to be lost."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

_LEAD_FRAMES = (20, 40)
"""So long the belief, which knows no motion at first, has time to learn it from what the tracker says."""


@njit(cache=True)
def frame_before(onsets: Any, rng: np.random.Generator) -> int:
    """Draw one of the frames (N,), -1 for none, on which something begins, and return one 20 to 40 frames earlier."""
    count = 0
    for k in range(len(onsets)):
        count += onsets[k] >= 0.0
    onset = int(onsets[int(rng.random() * count)]) if count > 0 else 0
    lead = _LEAD_FRAMES[0] + int(rng.random() * (_LEAD_FRAMES[1] - _LEAD_FRAMES[0]))
    return max(onset - lead, 0)
