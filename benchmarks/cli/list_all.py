"""``frameout list``: scenarios, suites, trackers, controllers, envs, and the page of definitions."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

from rich import box
from rich.table import Table

from benchmarks.cli.arguments import SEEDS, WithModules, check_unset, seed_range
from benchmarks.contract.suite import Suite, suites
from benchmarks.run.editions import preset_edition
from benchmarks.run.selection import trackers_of
from benchmarks.show.definitions import MetricDefinition, metric_definitions
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


@dataclass(frozen=True)
class List(WithModules):
    """List scenarios with their presets and contents, suites, trackers, controllers and envs.

    Attributes:
        measure: measure the contents of the presets again (without rendering) and store them, instead of showing the
            stored ones.
        seeds: episodes A to B - 1, or A alone, to measure.
        json: print JSON instead of tables.
        metrics: print the definitions of all metrics instead: formula, range, unit, better direction, conditions and
            source.
        reference: print the definitions of everything instead, as Markdown: truth, metrics, columns of results,
            settings of presets.
        envs: print the reference of the envs instead, as Markdown: ids, keywords, observation, actions,
            reward, `changes` and `randomise`, links, `info` keys, costs.
    """

    measure: bool = False
    seeds: Annotated[str, SEEDS] = "0:50"
    json: bool = False
    metrics: bool = False
    reference: bool = False
    envs: bool = False
    resumes = False

    def run(self) -> int:
        """Print it; return the exit status."""
        pages = [name for name in ("reference", "envs", "metrics", "measure") if getattr(self, name)]
        check("list", len(pages) <= 1, "one of --reference, --envs, --metrics, --measure", ", ".join(pages))
        markdown = self.reference or self.envs
        check("json", not (self.json and markdown), f"none with --{''.join(pages)}, which is Markdown", self.json)
        if not self.measure:
            check_unset(self, ("seeds",), "without --measure")
        if markdown:
            print(reference_page() if self.reference else envs_page(), end="")
            return 0
        if self.metrics:
            defined = [each for suite in suites().values() for each in metric_definitions(suite)]
            print(json.dumps([asdict(each) for each in defined], indent=1) if self.json else _as_text(defined))
            return 0
        if self.measure:
            _measure(seed_range(self.seeds))
        contents = _kept()
        if self.json:
            print(json.dumps(_as_data(contents), indent=1))
            return 0
        console = console_of()
        for name in catalog.names():
            for table in _scenario_tables(name, contents):
                console.print(table)
        for title, rows in _tables():
            console.print(_table(title, rows))
        return 0


def _as_text(defined: Sequence[MetricDefinition]) -> str:
    """Return definitions of metrics, some lines for each."""
    lines = []
    for each in defined:
        lines += [f"{each.suite}: {each.name}", f"    {each.summary}"]
        lines += [f"    {name + ':':<12}{getattr(each, name)}" for name in _PARTS]
        lines.append(f"    rows in:    {'; '.join(each.defined_in)}")
    return "\n".join(lines)


def _measure(seeds: range) -> None:
    """Write the contents of the presets of scenarios with a survey to the file in the package."""
    contents = _kept()
    for name in catalog.names():
        survey, presets = catalog.survey(name), catalog.scenario(name).presets
        if survey is None:
            continue
        held, editions = {}, {}
        with progress_bar("measuring presets") as progress:
            for k, (preset, configuration) in enumerate(presets.items()):
                progress(k, len(presets))
                held[preset] = survey.measure(configuration, seeds)
                editions[preset] = preset_edition(name, preset)
            progress(len(presets), len(presets))
        contents[name] = {"seeds": f"{seeds.start}:{seeds.stop}", "editions": editions, "holds": held}
    write_atomic(_CONTENTS, json.dumps(contents, indent=1) + "\n")


def _kept() -> dict[str, Any]:
    return json.loads(_CONTENTS.read_text()) if _CONTENTS.is_file() else {}


def _scenario_tables(name: str, contents: dict[str, Any]) -> Iterator[Table]:
    """Yield the presets of a scenario, and a second table with what was measured of them: side by side, the names would
    be cut in a narrow terminal.
    """
    scenario, survey, kept = catalog.scenario(name), catalog.survey(name), contents.get(name, {})
    table = Table(
        title=f"{scenario.id}: {scenario.summary}",
        caption=f"trackers are given: {scenario.start}",
        box=box.SIMPLE_HEAD,
    )
    for column in ("preset", "", "camera"):
        table.add_column(column, no_wrap=column != "")
    for preset, configuration in scenario.presets.items():
        table.add_row(preset, configuration.summary, "steered" if configuration.closed_loop else "not steered")
    yield table
    if survey is None:
        return
    measured = Table(caption=_measured(name, kept), box=box.SIMPLE_HEAD, pad_edge=False, collapse_padding=True)
    measured.add_column("preset", no_wrap=True)
    for column in survey.columns:
        measured.add_column(column, justify="right", no_wrap=True)
    for preset in scenario.presets:
        held = kept.get("holds", {}).get(preset)
        measured.add_row(preset, *(("?",) * len(survey.columns) if held is None else survey.cells(held)))
    yield measured


def _measured(name: str, kept: dict[str, Any]) -> str:
    if not kept:
        return "contents not measured yet (--measure)"
    measured = f"contents measured over episodes {kept['seeds']}"
    other = [preset for preset, edition in kept["editions"].items() if edition != preset_edition(name, preset)]
    if other:
        measured += f", of other editions of {', '.join(other)}; measure again: frameout list --measure"
    return measured


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


def _tables() -> list[tuple[str, list[tuple[str, str, str]]]]:
    trackers = {
        f"trackers of suite {name}{' beside those of its scenes' if suite.judges_controllers else ''}": trackers_of(
            name
        )
        for name, suite in suites().items()
    }
    steering = {f"controllers of the {name}": controllers(name) for name in _carriers()}
    return [
        ("suites", [(each["name"], each["kind"], each["summary"]) for each in _suites()]),
        *(
            (title, [(each.name, each.role, each.summary) for each in entries.values()])
            for title, entries in (trackers | steering).items()
        ),
        ("roles", [(role, "", words) for role, words in _ROLES.items()]),
        ("papers of the methods as written", [(each.name, each.about, each.reference()) for each in PAPERS.values()]),
        (
            "envs",
            [
                (
                    each["name"],
                    each["scenario"],
                    "Gymnasium env; defaults: tracker {tracker}, preset {preset}".format(**each),
                )
                for each in _envs()
            ],
        ),
    ]


def _envs() -> list[dict[str, str]]:
    return [
        {"name": name, "scenario": scenario, "tracker": tracker, "preset": catalog.env_preset(scenario)}
        for name, (scenario, tracker) in catalog.envs().items()
    ]


def _suites() -> list[dict[str, str]]:
    return [
        {"name": suite.name, "kind": "; ".join(_scenes(suite)), "summary": suite.summary} for suite in suites().values()
    ]


def _scenes(suite: Suite) -> Iterator[str]:
    """Yield the scenarios of a suite with the presets that it runs if none is named."""
    registered = set(map(unversioned, catalog.names()))
    for scene in suite.scenes:
        preset = scene.preset or suite.preset
        known = catalog.scenario(scene.scenario).presets if scene.scenario in registered else {preset: None}
        # A scenario without the suite's preset runs only when one of its own is named.
        yield f"{scene.scenario} {preset}" if preset in known else f"{scene.scenario} (--preset {', '.join(known)})"


def _carriers() -> list[str]:
    """Return the names of all carriers, in the order of the scenarios."""
    return list(dict.fromkeys(catalog.scenario(name).carrier.name for name in catalog.names()))


def _table(title: str, rows: list[tuple[str, str, str]]) -> Table:
    table = Table(title=title, show_header=False, box=box.SIMPLE)
    for column in range(3):
        table.add_column(overflow="fold", no_wrap=column == 0)
    for row in rows:
        table.add_row(*row)
    return table


def _as_data(contents: dict[str, Any]) -> dict[str, Any]:
    def entry(each: Any, **more: Any) -> dict[str, Any]:
        return {"name": each.name, "kind": each.role, "summary": each.summary, **more}

    return {
        "scenarios": [
            {
                "scenario": scenario.id,
                "summary": scenario.summary,
                "start": scenario.start,
                "presets": {
                    name: {"summary": preset.summary, "holds": contents.get(scenario.id, {}).get("holds", {}).get(name)}
                    for name, preset in scenario.presets.items()
                },
            }
            for scenario in map(catalog.scenario, catalog.names())
        ],
        "suites": _suites(),
        "controllers": [
            entry(each, carrier=carrier) for carrier in _carriers() for each in controllers(carrier).values()
        ],
        "trackers": [entry(each, suites=each.suites) for each in trackers_of().values()],
        "roles": _ROLES,
        "papers": [
            {"name": each.name, "summary": each.about, "reference": each.reference()} for each in PAPERS.values()
        ],
        "envs": _envs(),
    }
