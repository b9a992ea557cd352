"""Trackers that stay on the first box until they end, each in a way of its own."""

from __future__ import annotations

import os
import signal
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation


class Mortal:
    """Ends on frame 5."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._frame = 0

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        self._box_xyxy = box_xyxy.copy()

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        self._frame += 1
        if self._frame == 5:
            self.end()
        return Estimate(0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:]), self._box_xyxy)

    def end(self) -> None:
        """Do not."""


@register("innocent", role="external", summary="does not end")
class Innocent(Mortal):
    """Goes on."""


@register("exits", role="external", summary="ends its process")
class Exits(Mortal):
    """Leaves without a word."""

    def end(self) -> None:
        """See ``Mortal``."""
        os._exit(3)


@register("crashes", role="external", summary="crashes its process")
class Crashes(Mortal):
    """Is killed as by a fault in compiled code."""

    def end(self) -> None:
        """See ``Mortal``."""
        os.kill(os.getpid(), signal.SIGSEGV)


@register("stillborn", role="external", summary="ends its process when it is made")
class Stillborn(Mortal):
    """Is never made."""

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        os._exit(3)


@register("raises", role="external", summary="raises")
class Raises(Mortal):
    """Fails as Python does."""

    def end(self) -> None:
        """See ``Mortal``."""
        raise RuntimeError("no")


@register("unequipped", role="external", summary="lacks a package")
class Unequipped(Mortal):
    """Cannot begin."""

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        version("no_such_package")
