"""Runs of frames on which a flag is true."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first frame and end (the frame after the last) of every maximal run of true ``flags`` (T,)."""
    edges = np.flatnonzero(np.diff(np.pad(flags, 1)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
