"""``python -m tools scale``: what large sets cost, and how long it takes to handle one of very many episodes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from benchmarks.cli.arguments import FILE, Names
from benchmarks.data.sets.data_set import REQUEST
from benchmarks.data.sets.description import requests_of
from benchmarks.data.sets.episode_writer import MARK, episode_folder, write_background, write_episode
from benchmarks.data.sets.generating import FramesAlone
from benchmarks.data.sets.manifest import files_of
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import Request
from benchmarks.run.packages import needs_data
from benchmarks.run.result_folder import make_folder
from benchmarks.show.tables import markdown_table

_PART_BYTES = 50 * 2**20
"""Size of the parts in which ``s3fs`` sends a file; a larger one takes two requests more, to begin and to end it."""
_MOST_NAMES = 30_000
"""Names that one file gets; ext4 has at most 65,000."""
_HEADS = (
    "scene",
    "KiB a frame",
    "MiB an episode beside",
    "ms a frame",
    "s an episode beside",
    "frames an episode",
    "core hours",
    "TiB",
    "million files",
    "million requests",
    "at 1,000 workers: GiB/s",
    "files/s",
)
_STEPS = {
    "resume": "generate(request, out, Workers(0), lambda done, of: None)",
    "merge": "merge([out], None, lambda done, of: None)",
    "open": "DataSet(out)",
    "verify": "assert not list(problems(DataSet(out), lambda done, of: None))",
    "read 100 frames at random": (
        "data = DataSet(out); [data[int(k)] for k in np.random.default_rng(0).integers(0, len(data), 100)]"
    ),
}
_SCRIPT = """
import time
import numpy as np
from pathlib import Path
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers, generate
from benchmarks.data.sets.merging import merge
from benchmarks.data.sets.request import request_of
from benchmarks.data.sets.verifying import problems
out = {out!r}
request = request_of((Path(out) / "dataset.json").read_bytes(), "dataset.json")
from scenarios import catalog
catalog.scenario(request.scenario)
def peak_kib():
    # Not the maximum of getrusage, which begins with that of the process that started this one.
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1])
before, began = peak_kib(), time.process_time()
{step}
print(time.process_time() - began, (peak_kib() - before) / 1024)
"""

_SCENES = ("road-town", "stereo-follow", "fish-tank", "harbour")
_TINY = {"scenario": "fish-tank", "preset": "quick", "episodes": 1, "channels": "none", "set": {"frame_count": 2}}


@dataclass(frozen=True)
class Scale:
    """Print what a number of frames of each scene costs, computed from what a few of its frames cost here; and how long
    it takes to handle a set of very many tiny episodes. Tables are Markdown, for docs/ten-million-frames.md.

    Times are CPU time of one core, so that a busy machine does not change them.

    Attributes:
        scenes: of which costs are printed (default: all of the benchmark).
        frames: of the set that is computed. measured: of each scene that are made for that.
        clip: frames of an episode of a second set, of short clips.
        episodes: of the tiny set that is handled; 0 = none.
        out: folder for it (default: a temporary one).
    """

    scenes: Names = _SCENES
    frames: int = 10_000_000
    measured: int = 20
    clip: int = 20
    episodes: int = 100_000
    out: Annotated[Path | None, FILE] = None
    resumes = False

    def run(self) -> int:
        """Measure and print; return the exit status."""
        needs_data()
        if self.scenes != ("none",):
            print(markdown_table(_HEADS, list(self._costs()), 1))
        if self.episodes:
            with tempfile.TemporaryDirectory() as scratch:
                print(markdown_table(("step", *_counts_in_words(self.episodes)), self._handled(scratch), 1))
        return 0

    def _costs(self) -> Iterator[list[str]]:
        for scene in self.scenes:
            said = {"scenario": scene, "seeds": 0, "pictures": "jpeg", "channels": ["image_rgb", "instance_map"]}
            cost = _cost_of(requests_of(said)[""], self.measured)
            for length in (cost.frames, self.clip):
                yield [scene, *cost.of(self.frames, length)]

    def _handled(self, scratch: str) -> list[list[str]]:
        columns = []
        for count in (max(self.episodes // 100, 1), self.episodes):
            folder = (self.out or Path(scratch)) / str(count)
            began = time.process_time()
            write_tiny(folder, count)
            columns.append(
                [f"{time.process_time() - began:.1f} s", *(_measured(folder, step) for step in _STEPS.values())]
            )
        return [[name, *cells] for name, *cells in zip(["write the files", *_STEPS], *columns, strict=True)]


def _counts_in_words(episodes: int) -> list[str]:
    return [f"{count:,} episodes" for count in (max(episodes // 100, 1), episodes)]


@dataclass(frozen=True)
class Cost:
    """What a scene's episodes cost.

    Attributes:
        frames: of an episode. frame_s, episode_s: CPU time of a frame, and of what an episode needs beside its frames.
        frame_bytes, episode_bytes: likewise. files: of an episode. sizes: bytes of those that do not grow with frames.
    """

    frames: int
    frame_s: float
    episode_s: float
    frame_bytes: float
    episode_bytes: float
    files: int

    def of(self, frames: int, length: int) -> list[str]:
        """Return the cells of a table of a set of so many frames, in episodes of a length."""
        episodes = frames / length
        seconds = episodes * (self.episode_s + length * self.frame_s)
        stored = episodes * (self.episode_bytes + length * self.frame_bytes)
        large = max(self.episode_bytes, length * self.frame_bytes)
        requests = episodes * (self.files + (large / _PART_BYTES + 2 if large > _PART_BYTES else 0))
        a_second = 1000 / seconds
        return [
            f"{self.frame_bytes / 2**10:.1f}",
            f"{self.episode_bytes / 2**20:.1f}",
            f"{1000 * self.frame_s:.1f}",
            f"{self.episode_s:.2f}",
            str(length),
            f"{seconds / 3600:,.0f}",
            f"{stored / 2**40:.2f}",
            f"{episodes * self.files / 1e6:.2f}",
            f"{requests / 1e6:.2f}",
            f"{stored * a_second / 2**30:.2f}",
            f"{episodes * self.files * a_second:,.0f}",
        ]


def _cost_of(request: Request, frames: int) -> Cost:
    """Measure the first frames of a request's first episode, which has been built before: kernels are compiled."""
    began = time.process_time()
    with closing(request.episode(request.seeds[0])) as live, tempfile.TemporaryDirectory() as folder:
        files, root = place_of(folder)
        background = write_background(files, root, request, request.seeds[0], live)
        episode_s = time.process_time() - began
        shared = [size for size, _ in files_of(background).values()] if background else []
        began = time.process_time()
        first = FramesAlone(live, frames)
        write_episode(files, root, request, request.seeds[0], first)  # type: ignore[arg-type]
        frame_s = (time.process_time() - began) / first.frame_count
        written = [path.stat().st_size for path in Path(episode_folder(root, request.seeds[0])).iterdir()]
    kept = len(shared) + bool(shared)
    return Cost(
        live.frame_count, frame_s, episode_s, sum(written) / first.frame_count, sum(shared), len(written) + kept
    )


def write_tiny(folder: Path, episodes: int) -> None:
    """Write the files of many episodes of two frames, as the writer leaves them, but for the list and the card.

    Tables of all episodes have the bytes of the first one, so their column ``seed`` is wrong; marks are right.
    """
    make_folder(folder)
    request = requests_of(_TINY)[""]
    files, root = place_of(str(folder))
    with closing(request.episode(0)) as live:
        write_episode(files, root, request, 0, live)
    first = Path(episode_folder(root, 0))
    mark = json.loads((first / MARK).read_text())
    sources = {name: first / name for name in mark["files"]}
    for seed in range(1, episodes):
        place = Path(episode_folder(root, seed))
        place.mkdir()
        for name, source in sources.items():
            if seed % _MOST_NAMES:
                os.link(source, place / name)
            else:
                (place / name).write_bytes(source.read_bytes())
                sources[name] = place / name
        (place / MARK).write_text(json.dumps(mark | {"seed": seed}, indent=1) + "\n")
    (folder / REQUEST).write_text(replace(request, seeds=(0, episodes)).as_json())


def _measured(folder: Path, step: str) -> str:
    """Return the CPU time of a step in a process of its own, and the memory that it needs beside imports."""
    script = _SCRIPT.format(out=str(folder), step=step)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    seconds, mebibytes = map(float, done.stdout.split())
    return f"{seconds:.1f} s, {mebibytes:.0f} MiB"
