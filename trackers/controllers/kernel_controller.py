"""Controllers whose command is a kernel of the belief, and the PID terms that kernels add."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

import numpy as np

from trackers.belief.sighting import BeliefFilter
from trackers.controllers.catalogue import Kernel
from trackers.kernels.records import record_kernel
from trackers.types import BODY_COMMANDS, CameraCommand, CommandName, Estimate, Looks, Observation

PID_FIELDS: list[Any] = [
    # 1 if the previous frame had an error, else 0; and the time of the last one that had.
    ("has_error", "f8"),
    ("time_s", "f8"),
    ("error", "f8", (2,)),
    ("integral", "f8", (2,)),
]
PID_MEMORY = np.dtype(PID_FIELDS, align=True)
"""A kernel's memory, see ``catalogue.Kernel``. One with more fields has its own first, see ``record_dtype``."""


@record_kernel()
def seconds_since_error(memory: Any, time_s: float) -> float:
    """Note a frame with an error; return the time since the previous frame's, 0 if that had none."""
    interval_s = max(time_s - memory.time_s, 0.0) * memory.has_error
    memory.has_error, memory.time_s = 1.0, time_s
    return interval_s


@record_kernel()
def integral_and_derivative(
    memory: Any, axis: int, interval_s: float, error: float, gains: tuple[float, float], limit: float
) -> float:
    """Return ``gains[0] * integral + gains[1] * derivative`` after the next error on an axis.

    Args:
        interval_s: of ``seconds_since_error``. After a frame without an error the integral stays, and there is no
            derivative.
        limit: largest magnitude of the integral (anti-windup).
    """
    before, memory.error[axis] = memory.error[axis], error
    if interval_s == 0.0:
        return gains[0] * memory.integral[axis]
    memory.integral[axis] = min(max(memory.integral[axis] + interval_s * error, -limit), limit)
    return gains[0] * memory.integral[axis] + gains[1] * (error - before) / interval_s


def record_dtype(parameters: type) -> np.dtype[Any]:
    """Return the dtype of a record of a controller's parameters, as its kernel reads them: float64.

    Those that a class adds to another's come first: Numba would treat a record that begins like another as a subtype of
    it, and would use a kernel compiled for one on the other.
    """
    return np.dtype([(field.name, "f8") for field in reversed(dataclasses.fields(parameters))], align=True)


class KernelController:
    """Updates the belief with each estimate and commands what the kernel computes from it.

    Attributes:
        LOOKS: where the carrier's camera looks. COMMANDS: names (4,) of the kernel's numbers, see ``Carrier.commands``.
        KERNEL: see ``catalogue.Kernel``.
        parameters: the settings; they may be replaced between two pictures.
    """

    LOOKS: ClassVar[Looks]
    COMMANDS: ClassVar[tuple[CommandName, ...]] = BODY_COMMANDS
    KERNEL: ClassVar[Kernel]

    def __init__(self, parameters: Any) -> None:
        self.parameters = parameters
        self._beliefs = BeliefFilter(self.LOOKS)
        self._memory, self._command = np.zeros(1, self.KERNEL.memory), np.zeros((1, 4))

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command for the belief after this estimate."""
        belief, times_s = self._beliefs.update(observation, estimate), np.array([observation.time_s], dtype=float)
        self.KERNEL.steer(belief, self.KERNEL.record(self.parameters), self._memory, times_s, self._command)
        return CameraCommand(**dict(zip(self.COMMANDS, self._command[0].tolist(), strict=True)))


def share_beliefs(controller: object, beliefs: BeliefFilter) -> None:
    """Let a new controller take the beliefs that another computes from the same estimates, if it steers by beliefs."""
    if isinstance(controller, KernelController):
        controller._beliefs = beliefs
