"""``frameout bench``: run a suite and rank the trackers."""

from __future__ import annotations

import json
import sys
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import FOLDER, NAMES, SEEDS, WORKERS, cores, names, seed_range
from benchmarks.commands.leaderboard import print_leaderboard
from benchmarks.commands.progress import progress_bar
from benchmarks.commands.selection import parties
from benchmarks.report.page import write_report
from benchmarks.run.contestants import load_modules
from benchmarks.run.experiment import Experiment, Outcome, check_names, check_renderer, run
from benchmarks.suites.registry import Suite, suite

_QUICK_SEEDS = "10000:10003"


@dataclass(frozen=True)
class Bench:
    """Run a suite, rank the trackers, write rows, summary and report.

    Stopped at any moment, the same command goes on where it stopped. Trackers that fail have said nothing
    for the rest of the episode, and the exit status is 1; everyone else's results stand.

    Attributes:
        suites: what to run: frame-out, stereo, follow.
        scenario: of a suite about several, one or more (default: all of them).
        preset: presets of the scenario, one or more (default: standard; with --quick: quick).
        trackers: who takes part, one or more names, see `frameout list` (default: everyone of the suite;
            with --quick all but variants; in the suite follow ours and one other of each scenario).
        controllers: who steers the camera by the tracker's estimate, see `frameout list`; `set-path` = nobody, the
            same pictures for everyone (default: as the preset says; in the suite follow, which compares them,
            everyone). `policy:FILE` is a trained policy.
        link: in the suite follow, how commands reach the carrier: prompt, delayed or noisy.
        seeds: episodes A to B - 1; 0 to 9,999 are for development, 10,000 to 19,999 are the test split; with --quick
            10000:10003 unless given.
        renderer: raster or pybullet; the same picture, the latter from PyBullet's own renderer and slower.
        quick: a few small, short episodes, to see that everything works.
        out: folder for records.jsonl, summary.json, comparisons.json and report.html (default:
            results/SUITE, with --quick results/quick).
        workers: processes; 0 = none but this one.
        limit_s: the longest a tracker may take over one frame, in seconds.
        modules: your own Python modules that register trackers, imported first.
        backend: joblib's backend, where you have set up another than processes of this machine.
        json: print the summary as JSON instead of tables.
    """

    suites: Annotated[tuple[str, ...], tyro.conf.Positional] = ("frame-out",)
    scenario: Annotated[tuple[str, ...], NAMES] = ()
    preset: Annotated[tuple[str, ...], NAMES] = ()
    trackers: Annotated[tuple[str, ...], NAMES] = ()
    controllers: Annotated[tuple[str, ...], NAMES] = ()
    link: str = "prompt"
    seeds: Annotated[str, SEEDS] = "10000:10050"
    renderer: str = "raster"
    quick: bool = False
    out: Annotated[Path | None, FOLDER] = None
    workers: Annotated[int | None, WORKERS] = None
    limit_s: float = 60.0
    modules: Annotated[tuple[str, ...], NAMES] = ()
    backend: str = "loky"
    json: bool = False

    def run(self) -> int:
        """Run it; return the exit status."""
        status = 0
        for name in self.suites:
            status = max(status, self._run_suite(name))
        return status

    def _run_suite(self, name: str) -> int:
        load_modules(self.modules)
        wanted = suite(name)
        experiments = self._experiments(wanted)
        out = self.out or Path("results") / ("quick" if self.quick else wanted.name)
        outcome = Outcome()
        for experiment in experiments:
            with progress_bar(_what_runs(wanted, experiment)) as progress:
                outcome = outcome.followed_by(run(experiment, out, progress))
        report = write_report(out)
        if self.json:
            failures = [asdict(failure) for failure in outcome.failures]
            print(json.dumps({"summary": outcome.summary, "failures": failures, "report": str(report)}, indent=1))
        else:
            print_leaderboard(outcome.summary)
            print(f"rows: {out / 'records.jsonl'}\nreport: {report}")
        _tell_what_went_wrong(outcome, wanted)
        return 1 if outcome.failures else 0

    def _experiments(self, wanted: Suite) -> list[Experiment]:
        """Return what is to be run, an experiment for each scenario.

        Raises:
            ValueError: for wrong arguments, before anything is run.
        """
        if self.link != "prompt" and not wanted.judges_controllers:
            raise ValueError(f"link: expected prompt, since suite {wanted.name} knows no other, got {self.link!r}")
        preset = wanted.quick_preset if self.quick else wanted.preset
        quick_seeds = self.quick and self.seeds == type(self).seeds
        chosen = parties(
            wanted, names(self.scenario), names(self.trackers), names(self.controllers), variants=not self.quick
        )
        experiments = [
            Experiment(
                suite=wanted.name,
                scenario=party.scenario,
                presets=names(self.preset) or (preset,),
                trackers=party.trackers,
                seeds=seed_range(_QUICK_SEEDS if quick_seeds else self.seeds),
                renderer=check_renderer(self.renderer),
                controllers=party.controllers or None,
                link=self.link,
                workers=cores(self.workers),
                repeats=1 if self.quick else 3,
                limit_s=self.limit_s,
                modules=self.modules,
                backend=self.backend,
            )
            for party in chosen
        ]
        for experiment in experiments:
            check_names(experiment)
        return experiments


def _what_runs(wanted: Suite, experiment: Experiment) -> str:
    steering = f" × {len(experiment.controllers or ())} controllers" if wanted.judges_controllers else ""
    return f"{wanted.name}, {len(experiment.trackers)} trackers{steering}"


def _tell_what_went_wrong(outcome: Outcome, wanted: Suite) -> None:
    """Say on stderr, once for each tracker, that it failed or said nothing."""
    episodes = Counter(failure.tracker for failure in outcome.failures)
    told: set[str] = set()
    for failure in outcome.failures:
        if failure.tracker not in told:
            told.add(failure.tracker)
            others = episodes[failure.tracker] - 1
            more = f" (and failed in {others} more)" if others else ""
            print(f"error: {failure}{more}", file=sys.stderr)
    for tracker, frames in outcome.silent.items():
        if frames:
            print(
                f"note: {tracker} said nothing (NaN) on {frames} frames; each counts as {wanted.silence}",
                file=sys.stderr,
            )
