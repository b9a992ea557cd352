"""Methods that follow a target: what they are told, what they answer, and the registry of all of them.

Importing this imports no method: a public name is loaded where it is first asked for.
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
"""Public name -> module that defines it, or that it is the name of."""
__all__ = tuple(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(_HOMES[name])
    return getattr(home, name, home)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
