"""Scenarios: the catalogue, and the contracts of an episode and its truth.

Importing this package registers the env ids with Gymnasium, but imports neither Gymnasium nor a scene: a public name is
loaded on its first use.
"""

import importlib
from typing import Any

from scenarios.envs.ids import register_envs

_HOMES = {
    "catalog": "scenarios.catalog",
    "Episode": "scenarios.scenario",
    "Frame": "scenarios.scenario",
    "RendererName": "scenarios.scenario",
    "Scenario": "scenarios.scenario",
    "Truth": "scenarios.truth",
    "TruthExtent": "scenarios.truth",
    "Link": "scenarios.command_link",
    "Reward": "scenarios.envs.reward",
}
"""Public name -> the module that defines it; ``catalog`` is itself a module."""
__all__ = tuple(_HOMES)

register_envs()


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(_HOMES[name])
    return getattr(home, name, home)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
