"""``frameout generate``: make a data set."""

from __future__ import annotations

import sys
import time
from collections import Counter
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from benchmarks.cli.arguments import FILE, ONE_NAME, WORKERS, Names, Settings, UsualSeeds, WithModules, seeds_text
from benchmarks.contract.text import counted
from benchmarks.run.packages import needs_data
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from sim.checks import check

_OF_THE_RUN = ("out", "seeds", "config", "workers", "address", "on_error", "dry_run", "modules")
"""Options that say nothing about the set."""


@dataclass(frozen=True, kw_only=True)
class Generate(WithModules):
    """Make a data set: pictures with all their truth, resumable, on all cores or on a cluster.

    The same command continues after a stop; episodes are written whole or not at all. The bytes do not depend on the
    number of workers or on where they run. Commands that differ in --seeds alone may run at the same time, into one
    folder: `frameout merge` then makes it one set. Needs `pip install 'frameout[data]'`.

    Attributes:
        scenario: catalogue id, see `frameout list`; without a version the latest.
        out: folder, or URL such as s3://bucket/folder.
        config: YAML file that says what the set is of, in place of the options for that: scenario, preset, set, seeds
            or episodes, channels, pictures, renderer, splits, classes, negatives, and parts, each with such keys of its
            own. Everything is checked before anything is made (CONTRIBUTING.md, "Describe a data set").
        preset: one of the scenario's, on a set path or with a camera at rest.
        settings: another value of one of the preset's fields (`frameout list --reference`), may be given several times:
            frame_count=20, width_px=640, street_patterns=[grid]; drawn for each episode: traffic_cars=4:24,
            sun_elevation_deg=uniform(3,60), log_uniform(A,B), normal(MEAN,DEVIATION), choice(X,Y). It is a part of the
            preset's name, e.g. standard[traffic_cars=4:24], which every command takes.
        seeds: episodes A to B - 1, or A alone. With --config: make these alone, of each part those that it has.
        channels: names of the pictures and maps to store (default: all that the scenario has); none = boxes and the
            rest of the truth alone.
        pictures: coding of pictures: blosc2 (lossless, fastest), png (lossless), jpeg (quality 95) or jpeg-QUALITY.
        background: with --no-background the pictures without targets are left out, from which trackers of the harbour
            learn (50 to 95 MB, stored once for all episodes of a day): `frameout bench --data` then refuses the set.
        renderer: raster or pybullet.
        splits: shares of the episodes, e.g. train=0.8 val=0.1 test=0.1. A seed is always in the same split; those of
            the benchmark's test split (10000 to 19999) in test.
        classes: those that exports label, in the order of their numbers (default: all of the scene).
        negatives: largest share (0 to 1) of pictures without a labelled object in exports of single pictures.
        workers: processes; 0 = run in this process. On a cluster: half as many as the episodes under way at once.
        address: of the scheduler of a Dask cluster (`frameout[dask]`; default: processes of this machine).
        on_error: stop at the first episode that cannot be built, or skip it: the others are made, and the seeds that
            are left out are named at the end, in the data card and in manifest.parquet.
        dry_run: check everything, say what the set is, how large and how long it takes; make nothing.
    """

    scenario: Annotated[str | None, tyro.conf.Positional, tyro.conf.arg(help_behavior_hint="")] = None
    out: str
    seeds: UsualSeeds = None
    config: Annotated[Path | None, FILE] = None
    preset: str = "standard"
    settings: Settings = ()
    channels: Names = ()
    pictures: str = "blosc2"
    background: bool = True
    renderer: str = "raster"
    splits: Names = ()
    classes: Names = ()
    negatives: float = 1.0
    workers: Annotated[int | None, WORKERS] = None
    address: Annotated[str | None, ONE_NAME] = None
    on_error: Literal["stop", "skip"] = "stop"
    dry_run: bool = False
    resumes = True

    def run(self) -> int:
        """Make it; return the exit status."""
        needs_data()
        from benchmarks.cli.data_functions import generate

        said = self._said()
        if self.dry_run:
            self._forecast(said)
            return 0
        began, what = time.perf_counter(), self.scenario or str(self.config)
        with progress_bar(f"generate {what}") as progress:
            made = generate(
                said,
                self.out,
                seeds=self.seeds if self.config else None,
                workers=self.workers,
                address=self.address,
                modules=self.modules,
                on_error=self.on_error,
                progress=progress,
            )
        seconds = time.perf_counter() - began
        for data in made:
            room = f"{len(data)} frames, {data.size_bytes() / 2**30:.2f} GiB"
            taken = f", {seconds:.0f} s" if len(made) == 1 else ""
            print(f"{data.url}: {counted(len(data.seeds), 'episode')}, {room}{taken}")
            if not data.is_listed:
                first, end = data.request.seeds
                print(f"of {first}:{end} {counted(len(data.missing()), 'episode')} missing; at last: frameout merge")
            for seed, why in data.left_out.items():
                print(f"left out: seed {seed}: {why}", file=sys.stderr)
            if data.left_out:
                print(f"{counted(len(data.left_out), 'episode')} could not be built", file=sys.stderr)
        if len(made) > 1:
            print(f"{self.out}: {counted(len(made), 'part')}, {seconds:.0f} s")
        return 0

    def _said(self) -> dict[str, Any] | Path:
        """Return the description of the set."""
        own = [each for each in fields(self) if each.name not in _OF_THE_RUN]
        given = {each.name: getattr(self, each.name) for each in own if getattr(self, each.name) != each.default}
        if self.config is not None:
            names = ", ".join("--set" if name == "settings" else f"--{name}" for name in given if name != "scenario")
            check("config", "scenario" not in given, "no scenario beside it, as the file names it", self.scenario)
            check("config", not names, "a file that says all", f"{self.config} with {names}")
            return self.config
        check("scenario", self.scenario is not None, "a catalogue id (frameout list), or --config", "none")
        check("seeds", self.seeds is not None, "A:B", "none")
        given["seeds"] = self.seeds
        if self.settings:
            given["set"] = given.pop("settings")
        if self.splits:
            pairs = [each.partition("=") for each in self.splits]
            for name, _, share in pairs:
                check("splits", bool(share), "NAME=SHARE", repr(name))
            given["splits"] = {name: share for name, _, share in pairs}
        return given

    def _forecast(self, said: dict[str, Any] | Path) -> None:
        """Print what is asked for, resolved, and what it takes."""
        from benchmarks.cli.data_functions import chosen_of, described
        from benchmarks.data.sets.generating import forecast
        from benchmarks.data.sets.request import SPLITS

        workers = max(cores(self.workers), 1)
        for name, request in described(said, self.on_error).items():
            if name:
                print(f"{name}:")
            for each in fields(request):
                if each.name not in ("packages", "format"):
                    print(f"{each.name:>20} {_shown(getattr(request, each.name))}")
            splits = Counter(map(request.split_of, range(*request.seeds)))
            print(f"{'episodes':>20} {', '.join(f'{splits[split]} {split}' for split in SPLITS if splits[split])}")
            needed = forecast(request, on_error=self.on_error)
            for channel, size in needed.bytes_a_frame.items():
                print(f"{channel:>20} {size / 1024:9.1f} KiB a frame")
            minutes = needed.seconds / workers / 60
            print(f"{needed.frames} frames, {needed.bytes / 2**30:.2f} GiB, about {minutes:.1f} minutes")
            if self.config is not None and self.seeds is not None:
                print(f"of these now: seeds {seeds_text(chosen_of(request, self.seeds))}")


def _shown(value: Any) -> str:
    """Return the value of a request as a description writes it."""
    if isinstance(value, dict):
        return " ".join(f"{name}={each:g}" for name, each in value.items()) or "none"
    if isinstance(value, tuple):
        numbers = all(isinstance(each, int) for each in value)
        return (":" if numbers and value else " ").join(map(str, value)) or "none"
    return str(value)
