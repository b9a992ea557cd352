"""The camera's automatic settings as register values, checked."""

from __future__ import annotations

from trackers.types import CameraRegisters, Observation

_REGISTER_LIMITS = {"red": 1023, "blue": 1023, "shutter": 707, "gain": 683}


def camera_registers(observation: Observation, before: CameraRegisters | None = None) -> CameraRegisters:
    """Return the camera's register values; if it reports none, those ``before``.

    Raises:
        ValueError: if there are neither, or a value is out of range.
    """
    registers = (observation.settings.registers if observation.settings else None) or before
    if registers is None:
        raise ValueError("settings.registers: expected the camera's automatic settings as register values, got None")
    for name, largest in _REGISTER_LIMITS.items():
        value = getattr(registers, name)
        if not 0 <= value <= largest:
            raise ValueError(f"settings.registers.{name}: expected 0 to {largest}, got {value}")
    return registers
