"""Tracks of real animals, read from the file of a tracking program."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.checks import check


@dataclass(frozen=True, eq=False)
class TrackTable:
    """Tracks of N animals over T frames.

    Attributes:
        name: of the recording.
        position: (T, N, 2) x to the right and y down, in ``unit``; NaN where an animal was not tracked.
        names: (N,) of the animals.
        rate_hz: frames per second; None if the file does not tell.
        unit: ``px`` or ``cm``.
        first_frame: number of the first frame in the recording.
        notes: what a user should know of how it was read, a line each.
    """

    name: str
    position: NDArray[np.float64]
    names: tuple[str, ...]
    rate_hz: float | None = None
    unit: str = "px"
    first_frame: int = 0
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        shape = self.position.shape
        good = len(shape) == 3 and shape[1] == len(self.names) and shape[2] == 2
        check("position", good, f"the shape (frames, {len(self.names)}, 2)", shape)
        tracked = np.isfinite(self.position).any() if self.position.size else False
        check(self.name, bool(tracked), "an animal that is tracked on a frame", "none")
        check("rate_hz", self.rate_hz is None or 0 < self.rate_hz < np.inf, "a number > 0 or None", self.rate_hz)
        # Half a position is none, and programs write infinity too for what they do not know.
        known = np.isfinite(self.position).all(axis=2, keepdims=True)
        object.__setattr__(self, "position", np.where(known, self.position, np.nan))
