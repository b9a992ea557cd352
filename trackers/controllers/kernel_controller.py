"""A controller whose command is a kernel of the belief."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import numpy as np

from trackers.belief.belief_filter import BeliefFilter
from trackers.controllers.catalogue import Kernel
from trackers.types import CameraCommand, Estimate, Looks, Observation


def record_dtype(parameters: type) -> np.dtype[Any]:
    """Return the dtype of a record of a controller's parameters, as its kernel reads them: float64.

    Those that a class adds to another's come first: Numba would treat a record that begins like another as a subtype of
    it, and would use a kernel compiled for one on the other.
    """
    return np.dtype([(field.name, "f8") for field in reversed(dataclasses.fields(parameters))], align=True)


class KernelController:
    """Updates the belief with each estimate and commands what the kernel computes from it.

    Attributes:
        LOOKS: where the carrier's camera looks. KERNEL: see ``catalogue.Kernel``.
        parameters: the settings; they may be replaced between two pictures.
    """

    LOOKS: ClassVar[Looks]
    KERNEL: ClassVar[Kernel]

    def __init__(self, parameters: Any) -> None:
        self.parameters = parameters
        self._filter = BeliefFilter(self.LOOKS)
        self._memory, self._command = np.zeros(1, self.KERNEL.memory), np.zeros((1, 4))

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command for the belief after this estimate."""
        belief, times_s = self._filter.update(observation, estimate), np.array([observation.time_s], dtype=float)
        self.KERNEL.steer(belief, self.KERNEL.record(self.parameters), self._memory, times_s, self._command)
        return CameraCommand(*(float(number) for number in self._command[0]))
