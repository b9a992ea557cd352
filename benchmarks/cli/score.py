"""``frameout score``: score predictions made elsewhere."""

from __future__ import annotations

import inspect
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import FILE, FOLDER, ONE_NAME, RATE, WORKERS, Files, Names, UsualSeeds, WithModules
from benchmarks.cli.bench import print_results
from benchmarks.cli.printing import trackers_print_to_stderr
from benchmarks.cli.score_function import score
from benchmarks.contract.suite import DEFAULT, check_metrics, suite
from benchmarks.run.outcome import TrackerWarning
from benchmarks.show.progress import progress_bar


@dataclass(frozen=True)
class Score(WithModules):
    """Score predictions that trackers made elsewhere, with all metrics of a suite but those of speed and posteriors.

    Rows, leaderboard, `compare` and report are those of `frameout bench`: with its folder as --out the trackers stand
    beside those that ran there. Sequences are named as `frameout export` names them, such as
    SCENARIO-PRESET-000003, real ones as in the table by sequence. A sequence without predictions is named, and scored
    as silence.

    A folder of predictions is called like the tracker, or holds such folders. In it are a text file for each sequence,
    NAME.txt, data/NAME.txt (TrackEval) or NAME/NAME_001.txt (VOT toolkit), or one JSON file. The same command scores
    files that have changed since, and those alone.

    Attributes:
        suite: name of the suite, see `frameout list`, or one of yours: any but those whose camera is steered, or that
            need distances, which files of boxes lack.
        predictions: the folders.
        truth: a scenario of the suite, or the folder or URL of a data set of its episodes (default: the suite's first
            scenario).
        preset: one or more presets of the scenario (default: the suite's).
        seeds: episodes A to B - 1 (default: those of the data set, or that the predictions are of).
        real: folders of pictures with boxes in place of episodes, see `frameout bench --help`.
        layout: of the folders of --real (default: it is recognised).
        target: id or name of the target in files of several of --real (default: the one seen most).
        rate_hz: frames a second of the pictures of --real (default: as files say, else 30).
        format: vot: a line a frame, which is a rectangle left,top,width,height, a polygon, a mask, or one number for
            none; the picture begins at 0,0. otb: the same from 1,1, rectangles alone. mot: rows
            frame,id,left,top,width,height,confidence, counted from 1. mots: rows of masks, counted from 0,
            or as the names of real pictures count. coco: JSON results of COCO or TAO (default: coco of JSON, vot, mot
            or mots by the first lines of text). Confidences of vot and otb stand in NAME_confidence.value.
        annotations: JSON file of `frameout export --format coco` or tao-amodal, or of the real data set, whose pictures
            the image_ids of JSON results are.
        out: folder for rows, summary and report (default: results/SUITE, with --real results/SUITE-real).
        workers: number of worker processes; 0 = run in this process.
        metric: names of the metrics on the leaderboard, see `frameout list --metrics` (default: the suite's own).
        json: print the summary as JSON instead of tables.
    """

    suite: Annotated[str, tyro.conf.Positional] = DEFAULT
    predictions: Files = ()
    truth: Annotated[str, FOLDER] = ""
    preset: Names = ()
    seeds: UsualSeeds = None
    real: Files = ()
    layout: Annotated[str, ONE_NAME] = ""
    target: Annotated[str | None, ONE_NAME] = None
    rate_hz: Annotated[float | None, RATE] = None
    format: Annotated[str, ONE_NAME] = ""
    annotations: Annotated[Path | None, FILE] = None
    out: Annotated[Path | None, FOLDER] = None
    workers: Annotated[int | None, WORKERS] = None
    metric: Names = ()
    json: bool = False
    resumes = True

    def run(self) -> int:
        """Run it; return the exit status."""
        check_metrics(self.metric, [self.suite])
        given = {name: value for name, value in vars(self).items() if name in inspect.signature(score).parameters}
        with warnings.catch_warnings(), trackers_print_to_stderr():
            warnings.simplefilter("ignore", TrackerWarning)  # Printed after the leaderboard.
            results = score(**given | {"preset": self.preset or None}, progress=progress_bar)
        print_results(suite(self.suite), results, metric=self.metric, as_json=self.json, real=bool(self.real))
        return int(results.outcome.failed)
