"""Every controller by name."""

from __future__ import annotations

from trackers.controllers.centre import CentreController
from trackers.protocols import Controller

CONTROLLERS = {"centre": CentreController}


def create_controller(name: str) -> Controller:
    """Return a fresh controller with its default setting.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    if name not in CONTROLLERS:
        raise ValueError(f"controller: expected one of {', '.join(CONTROLLERS)}; got {name!r}")
    controller = CONTROLLERS[name]
    return controller(controller.Parameters())
