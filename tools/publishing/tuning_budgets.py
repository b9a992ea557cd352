"""What was spent on the parameters of contestants."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from benchmarks.contract.rows import Row
from scenarios import catalog
from trackers import registry
from trackers.controllers.catalogue import controller_entry
from trackers.registry import MethodEntry

_SPENT = ("trials", "preset", "seeds")


def budgets_of(rows: Iterable[Row]) -> dict[str, dict[str, Any]]:
    """Return trials, presets and seeds of tuning by name, of the ``trackers`` and ``controllers`` of rows.

    A contestant that could be tuned and was not has 0 trials. Left out are variants, which share the values of their
    tracker, papers' methods as written, and contestants without anything to tune.
    """
    known = registry.entries()
    pairs = {(row["scenario"], row["tracker"], row["controller"]) for row in rows}
    trackers = {
        tracker: _spent_on(known[tracker], known[tracker].tuned_as, known[tracker].tracker.__module__)
        for tracker in sorted({tracker for _, tracker, _ in pairs})
        if tracker in known and known[tracker].role not in ("variant", "as-written")
    }
    controllers = {}
    for name, carrier in sorted({(of, catalog.scenario(scene).carrier.name) for scene, _, of in pairs if of}):
        steering = controller_entry(name, carrier)
        controllers[name] = _spent_on(steering, f"controllers/{carrier}/{name}", steering.controller.__module__)
    return {"trackers": _without_none(trackers), "controllers": _without_none(controllers)}


def _spent_on(entry: MethodEntry, name: str, module: str) -> dict[str, Any] | None:
    """Return what the tuned file says, 0 trials without one, None if there is nothing to tune."""
    path = registry.tuned_file(name, module)
    if path.is_file():
        told = json.loads(path.read_text())
        return {key: told[key] for key in _SPENT}
    return {"trials": 0} if entry.tunables() else None


def _without_none(spent: Mapping[str, dict[str, Any] | None]) -> dict[str, Any]:
    return {name: budget for name, budget in spent.items() if budget is not None}
