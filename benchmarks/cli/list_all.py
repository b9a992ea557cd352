"""``frameout list``: scenarios, suites, trackers, controllers, envs, and the page of definitions."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

from benchmarks.cli.arguments import WithModules, seeds_text
from benchmarks.contract.suite import Suite, suites
from benchmarks.run.editions import preset_edition
from benchmarks.run.selection import trackers_of
from benchmarks.show.definitions import metric_definitions
from benchmarks.show.progress import console_of, progress_bar
from benchmarks.show.reference import envs_page, reference_page
from scenarios import catalog
from scenarios.catalog import unversioned
from sim.checks import check
from trackers.atomic_file import write_atomic
from trackers.controllers.catalogue import controllers
from trackers.papers import PAPERS

_PARTS = ("formula", "range", "unit", "better", "conditions", "source")
_CONTENTS = Path(__file__).with_name("preset_contents.json")
_MEASURED_SEEDS = range(50)
_ROLES = {
    "ours": "our own method",
    "variant": "ours or a paper's method with a part left out or changed",
    "as-written": "a paper's method, as the paper describes it",
    "tuned": "a method that stands with written values too, with the parameters that tuning found",
    "baseline": "a simple or general method",
    "external": "a user's own",
    "blind": "sees no picture; a tracker of this role gets the target's true state at the start and at each exit",
    "oracle": "knows what no tracker can know",
    "policy": "a trained network that steers",
}


@dataclass(frozen=True)
class List(WithModules):
    """List scenarios with their presets and contents, suites, trackers, controllers and envs.

    Attributes:
        measure: measure the contents of the presets again, over 50 episodes without rendering, and store them.
        json: print JSON instead of tables.
        metrics: print the definitions of all metrics instead: formula, range, unit, better direction, conditions and
            source.
        reference: print the definitions of everything instead, as Markdown: truth, metrics, columns of results,
            settings of presets.
        envs: print the reference of the envs instead, as Markdown: ids, keywords, observation, actions,
            reward, `changes` and `randomise`, links, `info` keys, costs.
    """

    measure: bool = False
    json: bool = False
    metrics: bool = False
    reference: bool = False
    envs: bool = False
    resumes = False

    def run(self) -> int:
        """Print it; return the exit status."""
        chosen = [name for name in ("measure", "json", "metrics", "reference", "envs") if getattr(self, name)]
        check("list", len(chosen) <= 1, "one of its options", ", ".join(chosen))
        if self.measure:
            _measure()
        elif self.json:
            print(json.dumps(_everything(), indent=1))
        elif self.metrics:
            print(_definitions())
        elif self.reference or self.envs:
            print(reference_page() if self.reference else envs_page(), end="")
        else:
            console = console_of()
            for table in _tables():
                console.print(table)
        return 0


def _definitions() -> str:
    """Return the definitions of metrics, some lines for each."""
    lines = []
    for each in (definition for suite in suites().values() for definition in metric_definitions(suite)):
        lines += [f"{each['suite']}: {each['name']}", f"    {each['summary']}"]
        lines += [f"    {name + ':':<12}{each[name]}" for name in _PARTS]
        lines.append(f"    rows in:    {'; '.join(each['defined_in'])}")
    return "\n".join(lines)


def _measure() -> None:
    """Write the contents of the presets of scenarios with a survey to the file in the package."""
    contents = _kept()
    for name in catalog.names():
        survey, presets = catalog.survey(name), catalog.scenario(name).presets
        if survey is None:
            continue
        held = {}
        with progress_bar(f"measuring presets of {name}") as progress:
            for k, (preset, configuration) in enumerate(presets.items(), 1):
                held[preset] = survey.measure(configuration, _MEASURED_SEEDS)
                progress(k, len(presets))
        editions = {preset: preset_edition(name, preset) for preset in presets}
        contents[name] = {"seeds": seeds_text(_MEASURED_SEEDS), "editions": editions, "holds": held}
    write_atomic(_CONTENTS, json.dumps(contents, indent=1) + "\n")


def _kept() -> dict[str, Any]:
    return json.loads(_CONTENTS.read_text()) if _CONTENTS.is_file() else {}


def _everything() -> dict[str, list[dict[str, Any]]]:
    """Return all that there is, by kind."""
    from benchmarks.data.layouts.layout import layouts  # It imports the readers of all layouts.

    contents = _kept()
    scenarios = [catalog.scenario(name) for name in catalog.names()]
    return {
        "scenarios": [
            {
                "scenario": scenario.id,
                "summary": scenario.summary,
                "start": scenario.start,
                "measured": contents.get(scenario.id, {}).get("seeds"),
                "presets": {
                    name: {
                        "summary": preset.summary,
                        "camera": "steered" if preset.closed_loop else "not steered",
                        "holds": contents.get(scenario.id, {}).get("holds", {}).get(name),
                    }
                    for name, preset in scenario.presets.items()
                },
            }
            for scenario in scenarios
        ],
        "suites": [
            {"name": name, "kind": "; ".join(_scenes(each)), "summary": each.summary} for name, each in suites().items()
        ],
        "trackers": [
            {"name": name, "kind": each.role, "suites": each.suites, "summary": each.summary}
            for name, each in trackers_of().items()
        ],
        "controllers": [
            {"name": name, "kind": each.role, "carrier": carrier, "summary": each.summary}
            for carrier in dict.fromkeys(scenario.carrier.name for scenario in scenarios)
            for name, each in controllers(carrier).items()
        ],
        "roles": [{"name": name, "summary": words} for name, words in _ROLES.items()],
        "papers": [
            {"name": each.name, "summary": each.about, "reference": each.reference()} for each in PAPERS.values()
        ],
        "layouts of bench --real": [{"name": each.name, "looks for": each.looks_for} for each in layouts().values()],
        "envs": [
            {"name": name, "scenario": scenario, "tracker": tracker, "preset": catalog.env_preset(scenario)}
            for name, (scenario, tracker) in catalog.envs().items()
        ],
    }


def _scenes(suite: Suite) -> Iterator[str]:
    """Yield the scenarios of a suite with the presets that it runs if none is named."""
    registered = set(map(unversioned, catalog.names()))
    for scene in suite.scenes:
        preset = scene.preset or suite.preset
        known = catalog.scenario(scene.scenario).presets if scene.scenario in registered else {preset: None}
        # A scenario without the suite's preset runs only when one of its own is named.
        yield f"{scene.scenario} {preset}" if preset in known else f"{scene.scenario} (--preset {', '.join(known)})"


def _tables() -> Iterator[Table]:
    kinds = _everything()
    for scenario in kinds.pop("scenarios"):
        title, start = f"{scenario['scenario']}: {scenario['summary']}", f"trackers are given: {scenario['start']}"
        presets = scenario["presets"]
        rows = [{"preset": name, "": each["summary"], "camera": each["camera"]} for name, each in presets.items()]
        yield _table(rows, title=title, caption=start)
        survey = catalog.survey(scenario["scenario"])
        if survey is not None and scenario["measured"] is not None:
            # In a table of its own: side by side, the names would be cut in a narrow terminal.
            cells = {name: survey.cells(each["holds"]) if each["holds"] else () for name, each in presets.items()}
            rows = [{"preset": name, **dict(zip(survey.columns, each, strict=False))} for name, each in cells.items()]
            yield _table(rows, caption=f"contents measured over episodes {scenario['measured']}")
    for kind, entries in kinds.items():
        yield _table(entries, title=kind)


def _table(entries: Sequence[Mapping[str, Any]], **words: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, collapse_padding=True, **words)  # type: ignore[arg-type]
    columns: list[str] = max(([*entry] for entry in entries), key=len, default=[])
    for column in columns:
        table.add_column(column, overflow="fold", no_wrap=column == columns[0])
    for entry in entries:
        table.add_row(*(", ".join(each) if isinstance(each, tuple) else each for each in entry.values()))
    return table
