"""Trackers and controllers: their inputs, outputs and registries.

Importing this package imports no method: a public name is loaded at its first use.
"""

import importlib
from typing import Any

_HOMES = {
    "CameraCommand": "trackers.types",
    "CameraModel": "trackers.types",
    "CameraRegisters": "trackers.types",
    "CameraSettings": "trackers.types",
    "Carrier": "trackers.types",
    "CommandAxis": "trackers.types",
    "EgoPose": "trackers.types",
    "Estimate": "trackers.types",
    "Observation": "trackers.types",
    "Controller": "trackers.protocols",
    "Tracker": "trackers.protocols",
    "registry": "trackers.registry",
    "register": "trackers.registry",
    "register_variant": "trackers.registry",
    "tunable": "trackers.registry",
    "controller_entry": "trackers.controllers.catalogue",
    "register_controller": "trackers.controllers.catalogue",
}
"""Public name -> the module that defines it, or the module of that name."""
__all__ = tuple(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(_HOMES[name])
    return getattr(home, name, home)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
