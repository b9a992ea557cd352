"""A world whose starts and steps are kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits


class KernelWorld:
    """See ``scenarios.scenario.World``; a scene supplies the kernels and their data.

    Attributes:
        begin_kernel: called with the arguments of ``begin``, the data before the sightings.
        move_kernel: called with the arguments of ``move``, link and data before the sightings.
    """

    state_dtype: np.dtype[Any]
    begin_kernel: Any
    move_kernel: Any

    def __init__(self, data: Any, link: LinkLimits) -> None:
        """``data`` is a named tuple of all that the kernels read, with ``camera`` and ``interval_s`` of ``World``."""
        self.camera: NDArray[np.float64] = data.camera
        self.interval_s: float = data.interval_s
        self._data, self._link = data, link

    def begin(self, states: Any, which: Any, episodes: Any, at_frame_outs: bool, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        self.begin_kernel(states, which, episodes, at_frame_outs, self._data, sightings, rng)

    def move(self, states: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        self.move_kernel(states, wanted, waiting, self._link, self._data, sightings, rng)
