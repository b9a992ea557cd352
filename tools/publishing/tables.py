"""The published tables, read from ``published.toml``: how each is made, by the same code as its command."""

from __future__ import annotations

import json
import tomllib
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.cli.arguments import seeds_text
from benchmarks.contract.rows import FILE_NAME, BlockKey, Row, read_blocks, rounded
from benchmarks.papers.camera_experiment import CameraExperiment
from benchmarks.papers.experiment import Finding, PaperExperiment, experiment_named, findings
from benchmarks.run.editions import Editions
from benchmarks.run.experiment import Experiment, Progress, run
from benchmarks.run.result_folder import make_folder, tidy
from benchmarks.run.selection import experiment_on
from benchmarks.statistics.summary import SUMMARY_FILE_NAME
from scenarios import catalog
from scenarios.scenario import RendererName
from sim.checks import check
from tools.time_speed import Speed
from trackers import registry
from trackers.controllers.catalogue import controller_entry
from trackers.registry import MethodEntry

_RENDERER: RendererName = "raster"
_SPENT = ("trials", "preset", "seeds")


@dataclass(frozen=True, kw_only=True)
class PublishedTable(ABC):
    """One published table.

    Attributes:
        name: of the table and its files.
        seeds: of the episodes, in the file [A, B].
    """

    name: str
    seeds: range

    @property
    @abstractmethod
    def command(self) -> str:
        """The command that makes the same rows."""

    @abstractmethod
    def editions_now(self) -> Callable[[BlockKey], Editions | None]:
        """Return what gives the present editions of a block of rows, None for one that is not the table's."""

    def make(self, out: Path, workers: int, progress: Progress) -> None:
        """Make what ``out`` lacks. Rows of what the table no longer has are moved to another file."""
        make_folder(out)
        kept = read_blocks(out) if (out / FILE_NAME).is_file() else {}
        now = self.editions_now()
        if gone := {key for key in kept if key.seed not in self.seeds or now(key) is None}:
            tidy(out, gone)
        self._run(out, workers, progress)

    @abstractmethod
    def _run(self, out: Path, workers: int, progress: Progress) -> None: ...

    def figures(self, out: Path, rows: Sequence[Row]) -> dict[str, Any]:
        """Return what is published of a run beside its rows: the last four keys of ``table_files``."""
        file = out / SUMMARY_FILE_NAME
        summary = json.loads(file.read_text()) if file.is_file() else []
        return {"budgets": {}, "summary": summary, "findings": [], "varied": None}


@dataclass(frozen=True, kw_only=True)
class BenchTable(PublishedTable):
    """Runs a suite.

    Attributes:
        suite: its name. scenario: catalogue id with its version. preset: of the scenario.
        trackers, controllers: by name. In the file, the trackers of a ``group`` stand before them.
    """

    suite: str
    scenario: str
    preset: str = "standard"
    trackers: Sequence[str]
    controllers: Sequence[str] = ()

    @property
    def experiment(self) -> Experiment:
        """What is run. Raises ValueError for unknown names."""
        named = (self.suite, self.scenario, (self.preset,), self.trackers, self.seeds)
        return experiment_on(*named, controllers=self.controllers or None)

    @property
    def command(self) -> str:
        """See ``PublishedTable``."""
        steered = f" --controllers {' '.join(self.controllers)}" if self.controllers else ""
        where = f"{self.suite} --scenario {self.scenario} --preset {self.preset}"
        return f"frameout bench {where} --trackers {' '.join(self.trackers)}{steered} --seeds {seeds_text(self.seeds)}"

    def editions_now(self) -> Callable[[BlockKey], Editions | None]:
        """See ``PublishedTable``."""
        return self.experiment.made_now

    def _run(self, out: Path, workers: int, progress: Progress) -> None:
        run(replace(self.experiment, workers=workers), out, progress)

    def figures(self, out: Path, rows: Sequence[Row]) -> dict[str, Any]:
        """See ``PublishedTable``."""
        return super().figures(out, rows) | {"budgets": budgets_of(rows)}


@dataclass(frozen=True, kw_only=True)
class PaperTable(PublishedTable):
    """Repeats a paper's experiment. Its methods are as written: nothing was spent on tuning.

    Attributes:
        experiment: its name.
    """

    experiment: str

    @property
    def paper(self) -> PaperExperiment:
        """What is run."""
        return experiment_named(self.experiment)

    @property
    def command(self) -> str:
        """See ``PublishedTable``."""
        return f"frameout paper {self.experiment} --seeds {seeds_text(self.seeds)}"

    def editions_now(self) -> Callable[[BlockKey], Editions | None]:
        """See ``PublishedTable``."""
        return self.paper.made_now(_RENDERER)

    def _run(self, out: Path, workers: int, progress: Progress) -> None:
        self.paper.run(out, self.seeds, _RENDERER, workers, progress)

    def figures(self, out: Path, rows: Sequence[Row]) -> dict[str, Any]:
        """See ``PublishedTable``. Measurements of a camera are of no suite: a finding is an entry of their summary."""
        made = self.paper
        found = list(map(_entry, findings(made, rows)))
        varied = made.sensitivity(out, rows, self.seeds, _RENDERER)
        figures = super().figures(out, rows) | {"findings": found, "varied": varied and varied._asdict()}
        if isinstance(made, CameraExperiment):
            heading = {"suite": made.suite, "scenario": made.scenario, "preset": made.preset}
            heading |= {"tracker": "none", "role": "measured", "renderer": _RENDERER}
            numbers = ("unit", "mean", "ci_low", "ci_high", "n")
            figures["summary"] = [
                {**heading, "metric": each["metric"], "better": "higher", **{key: each[key] for key in numbers}}
                for each in found
            ]
        return figures


def _entry(found: Finding) -> dict[str, Any]:
    claim = found.claim
    return {
        **{key: getattr(claim, key) for key in ("tracker", "minus", "metric", "counted")},
        "paper": claim.words,
        "expected": found.expected,
        "agrees": found.agrees,
        "unit": found.unit,
        **{key: rounded(asdict(found)[key]) for key in ("mean", "ci_low", "ci_high")},
        "n": found.episodes,
    }


@dataclass(frozen=True, kw_only=True)
class SpeedTable(PublishedTable):
    """Times pictures, on one core. Nothing of it can be equal in another run: there are no rows.

    Attributes:
        scenario: catalogue id with its version. preset: of the scenario.
        stored: whether the speed is that of data sets.
        frames: timed in each town.
    """

    scenario: str
    preset: str = "standard"
    stored: bool = False
    frames: int = Speed.frames

    @property
    def command(self) -> str:
        """See ``PublishedTable``."""
        frames = f" --frames {self.frames}" if self.frames != Speed.frames else ""
        stored = " --stored" if self.stored else ""
        return f"python -m tools speed {self.scenario} --seeds {seeds_text(self.seeds)}{frames}{stored}"

    def editions_now(self) -> Callable[[BlockKey], Editions | None]:
        """See ``PublishedTable``."""
        return lambda key: None

    def _run(self, out: Path, workers: int, progress: Progress) -> None:
        Speed((self.scenario,), self.preset, self.seeds, self.frames, self.stored, out=out).run()


def budgets_of(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return trials, presets and seeds of tuning by name, of the ``trackers`` and ``controllers`` of rows.

    One that could be tuned and was not has 0 trials. Left out are variants, which share the values of their tracker,
    papers' methods as written, and what has nothing to tune.
    """
    known = registry.entries()
    trackers = {
        name: _spent_on(known[name], known[name].tuned_as, known[name].tracker.__module__)
        for name in sorted({row["tracker"] for row in rows} & known.keys())
        if known[name].role not in ("variant", "as-written")
    }
    controllers = {}
    for scene, name in sorted({(row["scenario"], row["controller"]) for row in rows if row["controller"]}):
        carrier = catalog.scenario(scene).carrier.name
        steering = controller_entry(name, carrier)
        controllers[name] = _spent_on(steering, f"controllers/{carrier}/{name}", steering.controller.__module__)
    kinds = {"trackers": trackers, "controllers": controllers}
    return {kind: {name: each for name, each in spent.items() if each} for kind, spent in kinds.items()}


def _spent_on(entry: MethodEntry, name: str, module: str) -> dict[str, Any]:
    """Return what the tuned file says, 0 trials without one, nothing if there is nothing to tune."""
    path = registry.tuned_file(name, module)
    if path.is_file():
        tuned = json.loads(path.read_text())
        return {key: tuned[key] for key in _SPENT}
    return {"trials": 0} if entry.tunables() else {}


def _read_tables() -> tuple[PublishedTable, ...]:
    listed = tomllib.loads(Path(__file__).with_name("published.toml").read_text(encoding="utf-8"))
    kinds: dict[str, type[PublishedTable]] = {"bench": BenchTable, "paper": PaperTable, "speed": SpeedTable}
    tables = []
    for fields in listed["tables"]:
        if "group" in fields:
            fields["trackers"] = [*listed["groups"][fields.pop("group")], *fields.get("trackers", ())]
        tables.append(kinds[fields.pop("kind", "bench")](**fields | {"seeds": range(*fields["seeds"])}))
    return tuple(tables)


TABLES = _read_tables()
"""In the order of RESULTS.md."""


def tables_named(names: tuple[str, ...]) -> tuple[PublishedTable, ...]:
    """Return the tables of these names in the order of the list; () = all. Raises ValueError for an unknown name."""
    known = {table.name: table for table in TABLES}
    for name in names:
        check("tables", name in known, f"some of {', '.join(known)}", repr(name))
    return tuple(table for table in TABLES if table.name in (names or known))
