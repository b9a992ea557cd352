"""Scenarios: the catalogue, and the contracts of an episode and its truth.

Importing this package registers the env ids with Gymnasium. It imports no scene and no env: a public name is loaded on
its first use.
"""

import importlib
from typing import Any

from scenarios.own_packages import check_own_packages

_HOMES = {
    "catalog": "scenarios.catalog",
    "Episode": "scenarios.scenario",
    "Frame": "scenarios.scenario",
    "KeptWorld": "scenarios.scenario",
    "Labels": "scenarios.objects",
    "Objects": "scenarios.objects",
    "RendererName": "scenarios.scenario",
    "Scenario": "scenarios.scenario",
    "SceneCamera": "scenarios.stage",
    "Setup": "scenarios.scenario",
    "Stage": "scenarios.stage",
    "Truth": "scenarios.truth",
    "TruthExtent": "scenarios.truth",
    "truth_field": "scenarios.truth",
    "Link": "scenarios.command_link",
    "Reward": "scenarios.envs.reward",
}
"""Public name -> the module that defines it; ``catalog`` is itself a module."""
__all__ = tuple(_HOMES)

check_own_packages()
# Modules that need the packages which have just been checked.
importlib.import_module("sim.kernel_cache").ensure_kernel_cache()
importlib.import_module("scenarios.catalog")


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(_HOMES[name])
    return getattr(home, name, home)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
