"""Makes a set of rollouts: episodes in worker processes, then the files of its format, all of them or none."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numba
import numpy as np
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.data.exports.destination import README, whole_folder
from benchmarks.data.sets.request import of_seed
from benchmarks.learning.rollouts.card import Made, card_text
from benchmarks.learning.rollouts.recording import IN_VIEW, EpisodeFile, record
from benchmarks.learning.rollouts.request import Rollouts
from benchmarks.run.experiment import Progress
from benchmarks.run.own_modules import load_modules
from benchmarks.run.result_folder import alone_in, make_folder
from benchmarks.run.workers import in_processes
from sim.checks import check
from trackers.atomic_file import write_atomic

REQUEST = "rollouts.json"
"""File of a set that says what it is of."""
_EPISODES = "episodes"
_LOST = "a worker ended (killed, or out of memory); what was made is kept, the same command continues"


def make(rollouts: Rollouts, out: Path, workers: int, progress: Progress) -> Made:
    """Make a set in the folder ``out``, or return what is told of it if it is there.

    Episodes that are made are kept beside it, in ``OUT.unfinished``, from where the next call goes on.

    Raises:
        ValueError: if ``out`` holds something else, cannot be written, or is written by another process; for an episode
            in which the tracker or the controller fails.
        ChildProcessError: if a worker died.
    """
    target, asked = out.resolve(), rollouts.as_json()
    unfinished = target.with_name(f"{target.name}.unfinished")
    if not _is_made(target, asked):
        make_folder(unfinished)
        with alone_in(unfinished):
            _begin(unfinished, asked)
            folder = unfinished / _EPISODES
            seeds = range(*rollouts.seeds)
            missing = [seed for seed in seeds if not EpisodeFile(folder, seed).table_file.exists()]
            progress(len(seeds) - len(missing), len(seeds))
            try:
                made = in_processes(partial(_make_episode, rollouts, folder), missing, workers)
                for done, _ in enumerate(made, start=1 + len(seeds) - len(missing)):
                    progress(done, len(seeds))
            except BrokenProcessPool:
                raise ChildProcessError(_LOST) from None
            with whole_folder(str(target)) as whole:
                write_set(rollouts, [EpisodeFile(folder, seed) for seed in seeds], whole)
    if unfinished.exists():
        shutil.rmtree(unfinished)
    return Made(**json.loads((target / REQUEST).read_text())["made"])


def _is_made(target: Path, asked: str) -> bool:
    if not target.exists():
        return False
    if (target / REQUEST).is_file():
        _check_same(target / REQUEST, asked)
        return True
    taken = not target.is_dir() or any(target.iterdir())
    check("out", not taken, "a new or empty folder, or the same rollouts", f"{str(target)!r} with other files")
    return False


def _begin(unfinished: Path, asked: str) -> None:
    if (unfinished / REQUEST).is_file():
        _check_same(unfinished / REQUEST, asked)
    else:
        write_atomic(unfinished / REQUEST, asked)
    (unfinished / _EPISODES).mkdir(exist_ok=True)


def _check_same(path: Path, asked: str) -> None:
    """Raise ValueError, which names what differs, if a file asks for other rollouts."""
    try:
        kept, wanted = json.loads(path.read_text()), json.loads(asked)
    except ValueError as error:
        raise ValueError(f"out: expected {path} to say what rollouts are there, got {error}") from None
    for name, value in wanted.items():
        had = kept.get(name)
        check("out", had == value, f"rollouts with {name} {value!r}", f"{str(path.parent)!r} with {had!r}")


def _make_episode(rollouts: Rollouts, folder: Path, seed: int) -> int:
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(rollouts.modules)
    with of_seed(seed):
        record(rollouts, seed, folder)
    return seed


def write_set(rollouts: Rollouts, episodes: Sequence[EpisodeFile], folder: Path) -> None:
    """Write the files of a set of recorded episodes into an empty folder."""
    made = Made(
        episodes=len(episodes),
        steps=sum(episode.step_count for episode in episodes),
        mean_return=float(np.mean([episode.numbers("reward").sum() for episode in episodes])),
        time_in_view=float(np.mean([episode.numbers(IN_VIEW)[1:].mean() for episode in episodes])),
    )
    (folder / REQUEST).write_text(json.dumps(json.loads(rollouts.as_json()) | {"made": asdict(made)}, indent=1) + "\n")
    (folder / README).write_text(card_text(rollouts, episodes[0], made), encoding="utf-8")
    # Each format imports packages that the others do not need.
    if rollouts.format == "lerobot":
        from benchmarks.learning.rollouts.lerobot import write_lerobot

        write_lerobot(rollouts, episodes, folder)
    elif rollouts.format == "minari":
        from benchmarks.learning.rollouts.minari import write_minari

        write_minari(rollouts, episodes, folder)
    else:
        (folder / "data").mkdir()
        for episode in episodes:
            _linked(episode.table_file, folder / "data" / episode.table_file.name)


def _linked(source: Path, target: Path) -> None:
    """Put a file at a second place; the disk has it once, if it can."""
    try:
        target.hardlink_to(source)
    except OSError:
        shutil.copyfile(source, target)


def bytes_of(folder: Path) -> int:
    """Return the size of all files in a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def forecast(rollouts: Rollouts) -> tuple[float, float]:
    """Return about how many bytes a set takes, and how many seconds of one worker, by a set of its first episode."""
    first = replace(rollouts, seeds=(rollouts.seeds[0], rollouts.seeds[0] + 1))
    began = time.perf_counter()
    with TemporaryDirectory(prefix="frameout-") as scratch:
        episode, whole = record(first, first.seeds[0], Path(scratch)), Path(scratch) / "whole"
        whole.mkdir()
        write_set(first, [episode], whole)
        episodes = len(range(*rollouts.seeds))
        return episodes * bytes_of(whole), episodes * (time.perf_counter() - began)
