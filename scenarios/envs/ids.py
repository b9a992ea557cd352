"""Registration of the catalogue's env ids with Gymnasium."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

from scenarios import catalog

_REGISTRATION = "gymnasium.envs.registration"


def register_envs() -> None:
    """Register every env id with Gymnasium, now if it is loaded, otherwise when it is imported.

    Another call adds the catalogue's new ids. Gymnasium is not imported here: catalogue, trackers and benchmarks do not
    need it.
    """
    loaded = sys.modules.get(_REGISTRATION)
    if loaded is not None:
        _register(loaded)
    elif _RegistersOnImport not in sys.meta_path:
        sys.meta_path.insert(0, _RegistersOnImport)


def _register(registration: ModuleType) -> None:
    for entry in catalog.entries():
        if entry.env_id and entry.env_id not in registration.registry:
            registration.register(
                id=entry.env_id,
                entry_point="scenarios.envs.follow_env:FollowEnv",
                vector_entry_point="scenarios.envs.vector_entry:follow_vector_env",
                kwargs={"scenario": entry.id, "tracker": entry.tracker},
            )


class _RegistersOnImport:
    """An import finder that lets the other finders load Gymnasium's registry, and then registers the ids."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != _REGISTRATION:
            return None
        sys.meta_path.remove(_RegistersOnImport)
        spec = importlib.util.find_spec(name)
        if spec is None or spec.loader is None:
            return spec
        run = spec.loader.exec_module

        def run_and_register(module: ModuleType) -> None:
            run(module)
            _register(module)

        spec.loader.exec_module = run_and_register  # type: ignore[method-assign]
        return spec
