"""How a published table is made: by the same code as its command, into a folder, resumable."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from benchmarks.contract.rows import FILE_NAME, BlockKey, Row, read_blocks, rounded
from benchmarks.papers.camera_experiment import CameraExperiment
from benchmarks.papers.experiment import Finding, PaperExperiment, experiment_named, findings
from benchmarks.run.editions import Editions
from benchmarks.run.experiment import Experiment, Progress, run
from benchmarks.run.result_folder import make_folder, tidy
from benchmarks.run.selection import experiment_on
from benchmarks.statistics.summary import COMPARISONS_FILE_NAME, SUMMARY_FILE_NAME
from scenarios import catalog
from scenarios.scenario import RendererName
from tools.publishing.published import PublishedTable
from tools.time_speed import Speed
from trackers import registry
from trackers.controllers.catalogue import controller_entry
from trackers.registry import MethodEntry

_RENDERER: RendererName = "raster"
_SPENT = ("trials", "preset", "seeds")


@dataclass(frozen=True)
class TableRun(ABC):
    """The run of one published table.

    Attributes:
        table: its data.
    """

    table: PublishedTable

    @property
    @abstractmethod
    def command(self) -> str:
        """The command that makes the same rows."""

    @property
    def seeds(self) -> str:
        """The seeds as ``A:B``."""
        return f"{self.table.seeds.start}:{self.table.seeds.stop}"

    @abstractmethod
    def made_now(self, key: BlockKey) -> Editions | None:
        """Return the present ``editions`` of a block of rows, None for one that is not the table's."""

    def run(self, out: Path, workers: int, progress: Progress) -> None:
        """Make what ``out`` lacks. Rows of what the table no longer has are moved to another file."""
        make_folder(out)
        kept = read_blocks(out) if (out / FILE_NAME).is_file() else {}
        if gone := {key for key in kept if key.seed not in self.table.seeds or self.made_now(key) is None}:
            tidy(out, gone)
        self._make(out, workers, progress)

    @abstractmethod
    def _make(self, out: Path, workers: int, progress: Progress) -> None: ...

    def figures(self, out: Path, rows: Sequence[Row]) -> dict[str, Any]:
        """Return what is published of a run beside its rows: the last five keys of ``table_files``."""
        lists = {"summary": out / SUMMARY_FILE_NAME, "comparisons": out / COMPARISONS_FILE_NAME}
        read = {name: json.loads(file.read_text()) if file.is_file() else [] for name, file in lists.items()}
        return {"budgets": {}, **read, "findings": [], "varied": None}


class BenchRun(TableRun):
    """Runs a suite."""

    @cached_property
    def experiment(self) -> Experiment:
        """What is run. Raises ValueError for unknown names."""
        table = self.table
        named = (table.suite, table.scenario, (table.preset,), table.trackers, table.seeds)
        return experiment_on(*named, controllers=table.controllers or None)

    @property
    def command(self) -> str:
        """See ``TableRun``."""
        table = self.table
        steered = f" --controllers {' '.join(table.controllers)}" if table.controllers else ""
        where = f"{table.suite} --scenario {table.scenario} --preset {table.preset}"
        return f"frameout bench {where} --trackers {' '.join(table.trackers)}{steered} --seeds {self.seeds}"

    def made_now(self, key: BlockKey) -> Editions | None:
        """See ``TableRun``."""
        return self.experiment.made_now(key)

    def _make(self, out: Path, workers: int, progress: Progress) -> None:
        run(replace(self.experiment, workers=workers), out, progress)

    def figures(self, out: Path, rows: Sequence[Row]) -> dict[str, Any]:
        """See ``TableRun``."""
        return super().figures(out, rows) | {"budgets": budgets_of(rows)}


class PaperRun(TableRun):
    """Repeats a paper's experiment. Its methods are as written: nothing was spent on tuning."""

    @cached_property
    def experiment(self) -> PaperExperiment:
        """What is run."""
        return experiment_named(self.table.experiment)

    @property
    def command(self) -> str:
        """See ``TableRun``."""
        return f"frameout paper {self.table.experiment} --seeds {self.seeds}"

    def made_now(self, key: BlockKey) -> Editions | None:
        """See ``TableRun``."""
        return self._made_now(key)

    @cached_property
    def _made_now(self) -> Any:
        return self.experiment.made_now(_RENDERER)

    def _make(self, out: Path, workers: int, progress: Progress) -> None:
        self.experiment.run(out, self.table.seeds, _RENDERER, workers, progress)

    def figures(self, out: Path, rows: Sequence[Row]) -> dict[str, Any]:
        """See ``TableRun``. Measurements of a camera belong to no suite: each finding is an entry of their summary."""
        made = self.experiment
        found = list(map(_entry, findings(made, rows)))
        varied = made.sensitivity(out, rows, self.table.seeds, _RENDERER)
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


class SpeedRun(TableRun):
    """Times pictures, on one core. Nothing of it can be equal in another run: there are no rows."""

    @property
    def command(self) -> str:
        """See ``TableRun``."""
        table = self.table
        frames = f" --frames {table.frames}" if table.frames != Speed.frames else ""
        stored = " --stored" if table.stored else ""
        return f"python -m tools speed {table.scenario} --seeds {self.seeds}{frames}{stored}"

    def made_now(self, key: BlockKey) -> Editions | None:
        """See ``TableRun``."""
        return None

    def _make(self, out: Path, workers: int, progress: Progress) -> None:
        table = self.table
        Speed((table.scenario,), table.preset, table.seeds, table.frames, table.stored, out=out).run()


def run_of(table: PublishedTable) -> TableRun:
    """Return the run of a table."""
    kinds: dict[str, type[TableRun]] = {"bench": BenchRun, "paper": PaperRun, "speed": SpeedRun}
    return kinds[table.kind](table)


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
