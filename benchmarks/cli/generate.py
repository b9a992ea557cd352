"""``frameout generate``: make a data set."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import sys
import time
from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from benchmarks.cli.arguments import ONE_NAME, WORKERS, Names, Seeds, Settings, WithModules
from benchmarks.contract.text import counted
from benchmarks.run.editions import package_versions, preset_edition
from benchmarks.run.packages import needs_data
from benchmarks.run.selection import check_renderer
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from scenarios import catalog
from scenarios.field_values import is_drawn, with_values
from sim.checks import check


@dataclass(frozen=True)
class Generate(WithModules):
    """Make a data set: pictures with all their truth, resumable, on all cores or on a cluster.

    The same command continues after a stop; episodes are written whole or not at all. The bytes do not depend on the
    number of workers or on where they run. Needs `pip install 'frameout[data]'`.

    Attributes:
        scenario: catalogue id, see `frameout list`; without a version the latest.
        out: folder, or URL such as s3://bucket/folder.
        preset: one of the scenario's, on a set path or with a camera at rest.
        settings: another value of one of the preset's fields (`frameout list --contents`), may be given several times:
            frame_count=20, width_px=640, street_patterns=[grid]; drawn for each episode: traffic_cars=4:24,
            sun_elevation_deg=uniform(3,60), log_uniform(A,B), normal(MEAN,DEVIATION), choice(X,Y). It is a part of the
            preset's name, e.g. standard[traffic_cars=4:24], which every command takes.
        seeds: episodes A to B - 1, or A alone.
        channels: names of the pictures and maps to store (default: all that the scenario has).
        pictures: coding of pictures: blosc2 (lossless, fastest), png (lossless), jpeg (quality 95) or jpeg-QUALITY.
        background: with --no-background the pictures without targets are left out, from which trackers of the harbour
            learn (50 to 95 MB, stored once for all episodes of a day): `frameout bench --data` then refuses the set.
        renderer: raster or pybullet.
        workers: processes; 0 = run in this process. On a cluster: half as many as the episodes under way at once.
        address: of the scheduler of a Dask cluster (`frameout[dask]`; default: processes of this machine).
        on_error: stop at the first episode that cannot be built, or skip it: the others are made, and the seeds that
            are left out are named at the end, in the data card and in manifest.json.
        dry_run: say how large the data set will be and how long it takes; make nothing.
    """

    scenario: Annotated[str, tyro.conf.Positional]
    out: str
    seeds: Seeds
    preset: str = "standard"
    settings: Settings = ()
    channels: Names = ()
    pictures: str = "blosc2"
    background: bool = True
    renderer: str = "raster"
    workers: Annotated[int | None, WORKERS] = None
    address: Annotated[str | None, ONE_NAME] = None
    on_error: Literal["stop", "skip"] = "stop"
    dry_run: bool = False
    resumes = True

    def run(self) -> int:
        """Make it; return the exit status."""
        needs_data()
        from benchmarks.data.sets.generating import Workers, forecast, generate
        from benchmarks.data.sets.request import Request, existing_channels, of_seed

        scenario, preset = catalog.scenario(self.scenario), with_values(self.preset, self.settings)
        request = Request(
            scenario.id,
            preset,
            (self.seeds.start, self.seeds.stop),
            (),
            self.pictures,
            check_renderer(self.renderer),
            background=self.background,
            scene=preset_edition(scenario.id, preset),
            packages=package_versions() | {name: importlib.metadata.version(name) for name in ("blosc2", "pyarrow")},
        )
        for seed in self.seeds if is_drawn(request.configuration(), preset) else ():
            with of_seed(seed):
                request.configuration(seed)
        existing = existing_channels(request, self.on_error)
        for channel in self.channels:
            check("channels", channel in existing, f"some of {', '.join(existing)}", repr(channel))
        stored = tuple(channel for channel in existing if channel in self.channels or not self.channels)
        request = dataclasses.replace(request, channels=stored)
        workers = cores(self.workers)
        if self.dry_run:
            needed = forecast(request, on_error=self.on_error)
            for name, size in needed.bytes_a_frame.items():
                print(f"{name:>20} {size / 1024:9.1f} KiB a frame")
            minutes = needed.seconds / max(workers, 1) / 60
            print(f"{needed.frames} frames, {needed.bytes / 2**30:.2f} GiB, about {minutes:.1f} minutes")
            return 0
        began = time.perf_counter()
        with progress_bar(f"{request.scenario} {request.preset}") as progress:
            makers = Workers(workers, self.address, self.modules)
            data = generate(request, self.out, makers, progress, self.on_error)
        room = f"{len(data)} frames, {data.files.du(data.root) / 2**30:.2f} GiB"
        seconds = time.perf_counter() - began
        print(f"{self.out}: {counted(len(data.seeds), 'episode')}, {room}, {seconds:.0f} s")
        for seed, why in data.left_out.items():
            print(f"left out: seed {seed}: {why}", file=sys.stderr)
        if data.left_out:
            print(f"{counted(len(data.left_out), 'episode')} could not be built", file=sys.stderr)
        return 0
