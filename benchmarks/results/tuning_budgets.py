"""What was spent on the parameters of contestants."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from importlib import resources
from typing import Any

from benchmarks.run.records import Row
from scenarios import catalog
from trackers import registry

_SPENT = ("trials", "preset", "seeds")


def budgets_of(rows: Iterable[Row]) -> dict[str, dict[str, Any]]:
    """Return trials, presets and seeds of tuning by name, of the ``trackers`` and ``controllers`` of rows.

    Variants share the values of their tracker and are left out; so are contestants that were not tuned.
    """
    known = registry.entries()
    pairs = {(row["scenario"], row["tracker"], row["controller"]) for row in rows}
    trackers = {tracker: tracker for _, tracker, _ in pairs if tracker in known and known[tracker].tuned_as == tracker}
    controllers = {
        controller: f"controllers/{catalog.scenario(scenario).carrier.name}/{controller}"
        for scenario, _, controller in pairs
        if controller
    }
    return {"trackers": _spent_on(trackers), "controllers": _spent_on(controllers)}


def _spent_on(files: Mapping[str, str]) -> dict[str, Any]:
    found = {}
    for name, file in sorted(files.items()):
        path = resources.files("trackers").joinpath("tuned", f"{file}.json")
        if path.is_file():
            found[name] = {key: json.loads(path.read_text())[key] for key in _SPENT}
    return found
