"""Starts in the middle of an episode, shortly before a likely loss of the target."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

LEAD_FRAMES = (20, 40)
"""Range of the time before a likely loss: within it the belief, which starts without motion, learns it from the
tracker's answers."""


@njit(cache=True)
def begin_state(state: Any, episode: int, onsets: Any, before_onset: bool, rng: np.random.Generator) -> int:
    """Set a state to frame 0 of an episode, or to a frame before one of its ``onsets`` (N,); return the frame."""
    frame = frame_before(onsets, rng) if before_onset else 0
    state.episode, state.frame, state.steps, state.frames_out = episode, frame, 0, 0
    return frame


@njit(cache=True)
def frame_before(onsets: Any, rng: np.random.Generator) -> int:
    """Draw one of the frames ``onsets`` (N,), -1 for none, and return a frame 20 to 40 frames earlier, at least 0."""
    count = 0
    for k in range(len(onsets)):
        count += onsets[k] >= 0.0
    onset = int(onsets[int(rng.random() * count)]) if count > 0 else 0
    lead = LEAD_FRAMES[0] + int(rng.random() * (LEAD_FRAMES[1] - LEAD_FRAMES[0]))
    return max(onset - lead, 0)
