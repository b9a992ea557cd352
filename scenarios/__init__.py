"""Worlds to follow targets in: the catalogue, and what an episode and its truth are.

Importing this makes the env ids known to Gymnasium, and imports neither Gymnasium nor a world: a public name is loaded
where it is first asked for.
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
"""Public name -> module that defines it, or that it is the name of."""
__all__ = tuple(_HOMES)

register_envs()


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(_HOMES[name])
    return getattr(home, name, home)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
