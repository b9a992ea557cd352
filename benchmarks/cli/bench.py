"""``frameout bench``: run a suite and rank the trackers."""

from __future__ import annotations

import inspect
import json
import sys
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import (
    COUNT,
    FILE,
    FOLDER,
    ONE_NAME,
    RATE,
    WORKERS,
    Files,
    Names,
    Processes,
    Settings,
    UsualSeeds,
    Values,
    WithModules,
)
from benchmarks.cli.bench_function import bench, check_suites, stored_seeds, with_added
from benchmarks.cli.leaderboard import print_leaderboard
from benchmarks.cli.printing import trackers_print_to_stderr
from benchmarks.contract.rows import REAL, Row, read_rows
from benchmarks.contract.suite import DEFAULT, Suite, check_metrics, suite
from benchmarks.contract.text import printable
from benchmarks.run.outcome import TrackerWarning
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.result_folder import check_file
from benchmarks.run.selection import varied_names
from benchmarks.show.page import REPORT_FILE_NAME, is_current, write_report
from benchmarks.show.progress import progress_bar
from benchmarks.show.provenance import sequences_in_words
from benchmarks.show.results import Results
from benchmarks.statistics.rank_agreement import rank_agreement
from sim.checks import check
from trackers.atomic_file import write_atomic

_SEEDS, _QUICK_SEEDS = range(10_000, 10_050), range(3)


@dataclass(frozen=True)
class Bench(WithModules):
    """Run a suite, rank the trackers, write rows, summary and report.

    A run that was stopped continues with the same command. A tracker that fails counts as giving no answer for the
    rest of the episode, and the exit status is 1; the results of the others are not affected.

    Attributes:
        suites: names of the suites to run, see `frameout list`.
        scenario: one or more of the suite's scenarios (default: all that have the preset).
        preset: one or more presets of the scenarios (default: standard; with --quick: quick).
        settings: another value of one of their fields, FIELD=VALUE, see `generate`; the name of the preset then has it.
        trackers: names of trackers, see `frameout list` (default: all of the suite; with --quick all but variants;
            in the suite follow ours and one other for each scenario).
        vary: a tracker with other values of one of its parameters, e.g. `colour_pf.particles=50,200,1000`, one or more;
            each value is a row of its own, `colour_pf[particles=50]`, a name that all commands take. The report draws
            the score over the time a frame. Without --trackers they run alone.
        process: a tracker in a process of its own, NAME=COMMAND, or a TOML file with a table for each of several; may
            be given several times. They run beside the others, or alone if --trackers names them, see CONTRIBUTING.md.
        controllers: names of controllers that steer the camera by the tracker's estimate, see `frameout list`;
            `policy:FILE` is a trained policy; `set-path` moves the camera on a fixed path, so that all trackers get
            the same pictures (default: given by the preset; in the suite follow all controllers of `frameout list`).
        link: how commands reach the carrier: prompt, delayed, noisy or late; for the suite follow only.
        seeds: episodes A to B - 1, or A alone; 0 to 9,999 are for development, 10,000 to 19,999 are the test split,
            later ones belong to neither (default: 10000:10050, with --quick 0:3).
        renderer: raster, or pybullet for PyBullet's own renderer, which is slower.
        data: folder or URL of a data set of `frameout generate` (`frameout[data]`): its stored episodes take the place
            of rendered ones and give the same scores; it also sets scenario, preset, renderer and, unless you name
            fewer, seeds.
        keep_estimates: also leave all answers of all trackers as tables, in the folder `estimates` beside the rows
            (`frameout[data]`); `frameout report --from-estimates` judges them again, but for those of --real.
        real: what is real in place of episodes; what cannot be used is named, and the rest is scored. For the suite
            fish files of tracks, of TRex (npz, csv), idtracker.ai (csv, h5, parquet), idTracker, Tracktor, SLEAP (csv,
            h5, slp) and DeepLabCut (csv, h5), and rows of MOT; gaps are cut out of the tracks and bridged, and pieces
            of tracks linked; intervals are over blocks of time. For the suite frame-out folders of pictures with the
            boxes of one target, see --layout: each folder, of one sequence or many, gets a leaderboard, in pixels
            alone; intervals are over its sequences. For the suite many folders of MOT Challenge or DanceTrack, in which
            all targets are followed.
        layout: of the folders of --real, which is recognised unless you choose it: coco, davis (YouTube-VOS too),
            got10k, kitti (tracking), lasot, mot (DanceTrack too), mots, otb, oxuva, tao (TAO-Amodal too), trackingnet,
            uav123, uavdt, vot (VOTS too), or, as `frameout export` writes them, webdataset or yolo. What each looks
            for `frameout list` says. A folder is a data set's, or a part or one sequence of it.
            Trackers start on the first picture that shows the target. A picture with a box counts as in view, one that
            files call outside, or that has no box, as a frame-out; one that they call hidden is no frame-out, and one
            without a label is shown and counts in no score.
        target: id or name of the target to follow in files of many (default: the one with most labels).
        rate_hz: frames a second of the pictures of --real (default: as files say, else 30).
        beside: with --real, folder of results in simulated episodes: also prints both orders of the trackers and
            their rank correlation, Kendall's tau, with an interval, and what counts on either side.
        quick: run a few small, short episodes as a trial.
        out: folder for records.jsonl, summary.json, comparisons.json and report.html (default: results/SUITE, with
            --quick results/quick, with --real results/SUITE-real).
        workers: number of worker processes; 0 = run in this process.
        limit_s: most CPU time in seconds for one frame of a tracker, of all its threads; it may wait, e.g. sleep or
            be kept from a core by others, until ten times as many seconds went by.
        real_time: pictures a second, e.g. 20, that arrive whether a tracker is ready or not, as in VOT's real-time
            experiment: those that arrive while it works on an earlier one are lost to it, and its last answer stands
            for them. By the measured wall time of each answer, so run it on an idle machine, with few workers. A folder
            holds rows of one rate (default: pictures wait; with a rate the folder's name ends with it).
        repeats: runs of each tracker in each episode, with random numbers of their own (default: 3 of a tracker that no
            seed makes reproducible, with --quick 1; else 1).
        metric: names of the metrics on the leaderboard, see `frameout list --metrics` (default: the suite's own).
        json: print the summary as JSON instead of tables.
        csv: also write all numbers of the rows as a table, a line for each condition, seed, tracker, event and metric,
            to this file. Lists, e.g. the error on each frame, stay in records.jsonl. In Python:
            `benchmarks.bench(…).rows()`.
    """

    suites: tyro.conf.Positional[Names] = (DEFAULT,)
    scenario: Names = ()
    preset: Names = ()
    settings: Settings = ()
    trackers: Names = ()
    vary: Values = ()
    process: Processes = ()
    controllers: Names = ()
    link: str = "prompt"
    seeds: UsualSeeds = None
    renderer: str = "raster"
    data: Annotated[str | None, FOLDER] = None
    keep_estimates: bool = False
    real: Files = ()
    layout: Annotated[str, ONE_NAME] = ""
    target: Annotated[str | None, ONE_NAME] = None
    rate_hz: Annotated[float | None, RATE] = None
    beside: Annotated[Path | None, FOLDER] = None
    quick: bool = False
    out: Annotated[Path | None, FOLDER] = None
    workers: Annotated[int | None, WORKERS] = None
    limit_s: float = 60.0
    real_time: Annotated[float | None, RATE] = None
    repeats: Annotated[int | None, COUNT] = None
    metric: Names = ()
    json: bool = False
    csv: Annotated[Path | None, FILE] = None
    resumes = True

    def run(self) -> int:
        """Run it; return the exit status."""
        check_metrics(self.metric, self.suites)
        if self.csv is not None:
            check_file(self.csv, "csv")
        if not self.real:
            added = process_trackers(self.process, self.limit_s)
            chosen = {
                "scenarios": self.scenario,
                "presets": self.preset,
                "settings": self.settings,
                "trackers": with_added((*self.trackers, *varied_names(self.vary)), added),
                "controllers": self.controllers,
            }
            check_suites(
                map(suite, self.suites),
                chosen,
                added,
                link=self.link,
                data=self.data,
                quick=self.quick,
                modules=self.modules,
            )
        made = [self._run_suite(suite(name)) for name in self.suites]
        if self.csv is not None:
            from benchmarks.show.results import numbers_table

            rows = [row for folder in dict.fromkeys(out for out, _ in made) for row in read_rows(folder)]
            write_atomic(self.csv, numbers_table(rows).to_csv(index=False))
        return int(any(failed for _, failed in made))

    def _run_suite(self, wanted: Suite) -> tuple[Path, bool]:
        """Return the folder, and whether a tracker failed."""
        pictures = bool(self.real) and wanted.on_sequences is not None
        beside = pictures or self.beside is None
        check("beside", beside, "none but with --real and a suite that judges pictures", repr(str(self.beside)))
        simulated = read_rows(self.beside) if self.beside is not None else []
        results = self._rows_of(wanted)
        print_results(wanted, results, metric=self.metric, as_json=self.json, real=bool(self.real), beside=simulated)
        return results.directory, results.outcome.failed

    @trackers_print_to_stderr()
    def _rows_of(self, wanted: Suite) -> Results:
        seeds = self.seeds
        if seeds is None and not self.real:
            seeds = stored_seeds(self.data) if self.data is not None else _QUICK_SEEDS if self.quick else _SEEDS
        named = {name: getattr(self, name) or None for name in ("scenario", "preset", "trackers", "controllers")}
        # All that command and function have in common.
        given = {name: value for name, value in vars(self).items() if name in inspect.signature(bench).parameters}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", TrackerWarning)  # Printed after the leaderboard.
            return bench(wanted, **given | named | {"seeds": seeds}, progress=progress_bar)


def print_results(
    wanted: Suite,
    results: Results,
    *,
    metric: tuple[str, ...],
    as_json: bool,
    real: bool,
    beside: Sequence[Row] = (),
) -> None:
    """Print the leaderboard of a suite, write the report, and name what went wrong.

    Args:
        metric: names of the metrics on the leaderboard; () = the suite's own.
        real: whether the results are of what is real.
        beside: rows of simulated episodes, whose order of the trackers is compared.
    """
    out, outcome = results.directory, results.outcome
    # The folder may hold rows of other suites.
    summary, rows = [entry for entry in outcome.summary if entry["suite"] == wanted.name], read_rows(out)
    if not as_json:
        print_leaderboard(summary, metric, rows=rows)
    report = out / REPORT_FILE_NAME
    if is_current(out, metric):
        print("nothing new: the report stays as it is", file=sys.stderr)
    else:
        from benchmarks.data.real import reopened  # It imports the readers of all layouts.

        print("making the report; trackers run again for its pictures …", file=sys.stderr)
        with trackers_print_to_stderr():
            write_report(out, metric, reopened, progress_bar)
    if as_json:
        document = {"summary": summary, "failures": list(map(asdict, outcome.failures)), "report": str(report)}
        print(json.dumps(document, indent=1))
    else:
        lines = sequences_in_words(wanted, rows) if real else []
        agreement = rank_agreement(wanted, rows, beside) if beside else []
        print(*lines, *agreement, printable(f"rows: {out / 'records.jsonl'}\nreport: {report}"), sep="\n")
    for line in outcome.problems_in_words(wanted.silence_in(REAL if real else "")):
        print(line, file=sys.stderr)
