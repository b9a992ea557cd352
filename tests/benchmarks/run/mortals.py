"""Trackers that stay on the first box until they end, each in a way of its own."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation


def _raise() -> None:
    raise RuntimeError("no")


def _nothing() -> None:
    """Do not end."""


_ENDS: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
    "innocent": (_nothing, _nothing),
    "exits": (_nothing, lambda: os._exit(3)),
    "crashes": (_nothing, lambda: os.kill(os.getpid(), signal.SIGSEGV)),
    "raises": (_nothing, _raise),
    "stillborn": (lambda: os._exit(3), _nothing),
    "unequipped": (lambda: version("no_such_package"), _nothing),
}
"""Tracker -> what it does when it is made, and on frame 5."""


def _register(name: str, at_first: Callable[[], Any], on_frame_5: Callable[[], Any]) -> None:
    @register(name, role="external", summary="ends, or does not")
    class _Mortal:
        Parameters = NoParameters

        def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
            at_first()
            self._frame = 0

        def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
            self._box_xyxy = box_xyxy.copy()

        def update(self, observation: Observation) -> Estimate:
            self._frame += 1
            if self._frame == 5:
                on_frame_5()
            return Estimate(0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:]), self._box_xyxy)


for _name, _ends in _ENDS.items():
    _register(_name, *_ends)
