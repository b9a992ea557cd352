"""Runs a suite: every tracker in every episode, on all cores, resumable, safe from failing trackers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any

from benchmarks.contract.rows import ESTIMATES, FILE_NAME, REAL, BlockKey, Row
from benchmarks.contract.suite import Suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.editions import Editions
from benchmarks.run.episodes import EpisodeSpec, editions_of
from benchmarks.run.failures import earlier, read_failures, write_failures
from benchmarks.run.jobs import Job, Keeper, key_of, run_count
from benchmarks.run.outcome import Outcome
from benchmarks.run.process_trackers import ProcessTracker
from benchmarks.run.result_folder import alone_in, append_block, make_folder, tidy, up_to_date
from benchmarks.run.time_limit import check_limit
from benchmarks.run.workers import end_workers, results
from benchmarks.statistics.summary import write_summary
from sim.checks import check


@dataclass(frozen=True)
class Experiment:
    """What is run.

    Attributes:
        suite: judges.
        episodes: in which all trackers run, seed by seed: a worker keeps what it has drawn of the latest world.
        trackers: name in rows → the tracker.
        workers: processes; 0 = this process (then a tracker that ends its process ends the run).
        repeats: runs of each tracker in an episode, see ``Job``.
        limit_s: of CPU time of a tracker for one frame, see ``time_limit.at_most``.
        real_time_hz: pictures a second, see ``run.real_time``; None = they wait for the trackers.
        modules: users' own modules, which are imported already; workers import them first.
        keeper: keeps all answers beside the rows; None = they are not kept.
    """

    suite: Suite
    episodes: Sequence[EpisodeSpec]
    trackers: Mapping[str, TrackerSpec]
    workers: int = 1
    repeats: int | None = None
    limit_s: float = 60.0
    real_time_hz: float | None = None
    modules: tuple[str, ...] = ()
    keeper: Keeper | None = None

    def __post_init__(self) -> None:
        check("workers", self.workers >= 0, "a whole number >= 0", self.workers)
        check_limit(self.limit_s)
        good = self.repeats is None or (isinstance(self.repeats, int) and self.repeats > 0)
        check("repeats", good, "a whole number > 0", repr(self.repeats))
        alone = self.repeats in (None, 1) or all(each.steering is None for each in self.episodes)
        check("repeats", alone, "1 where a controller steers, which follows one run of a tracker", repr(self.repeats))
        rate_hz = self.real_time_hz
        good = rate_hz is None or (isinstance(rate_hz, int | float) and 0 < rate_hz < inf)
        check("real_time", good, "pictures a second, a number > 0", repr(rate_hz))
        at_once = [name for name, each in self.trackers.items() if each.takes_all and rate_hz is not None]
        check("real_time", not at_once, "none with trackers that get all pictures at once", ", ".join(at_once))

    @property
    def block_count(self) -> int:
        """Number of blocks of rows; all of a recording's count as one."""
        return len(self.episodes) * len(self.trackers)

    @cached_property
    def _known(self) -> dict[tuple[Any, ...], Editions]:
        return {}

    def _editions(self, episode: EpisodeSpec, tracker: str) -> Editions:
        """Read once for each kind of episode, whatever its seed: users may edit their code during a run."""
        which = episode.seed if episode.scenario is None else None
        kind = (
            episode.preset,
            which,
            episode.steering and episode.steering.name,
            tracker,
            self.trackers[tracker].content(episode),
        )
        if kind not in self._known:
            self._known[kind] = editions_of(self.suite, episode, self.trackers[tracker])
        return self._known[kind]

    @cached_property
    def _episodes_by_key(self) -> dict[BlockKey, EpisodeSpec]:
        return {key_of(self.suite, each, ""): each for each in self.episodes}

    def made_now(self, key: BlockKey) -> Editions | None:
        """Return the present ``editions`` of a block; None for the blocks of others."""
        episode = self._episodes_by_key.get(replace(key, tracker=""))
        return self._editions(episode, key.tracker) if episode is not None and key.tracker in self.trackers else None

    def run_count(self, key: BlockKey) -> int:
        """Return how often the tracker of one of its blocks runs in the episode."""
        return run_count(self.trackers[key.tracker], self.repeats)

    def jobs(self, out: Path | None = None, have: set[BlockKey] | frozenset[BlockKey] = frozenset()) -> Iterator[Job]:
        """Yield a job for each episode with pictures on a set path, else for each tracker in it, without what there is
        already, ``have``.

        Args:
            out: folder of the rows; None for a trial, whose rows have no editions.
        """
        for episode in self.episodes:
            left = [name for name in self.trackers if key_of(self.suite, episode, name) not in have]
            together = episode.steering is None and (episode.scenario is not None or bool(episode.sequence))
            for group in [left] if together else [[name] for name in left]:
                if group:
                    yield Job(
                        suite=self.suite,
                        episode=episode,
                        trackers={name: self.trackers[name] for name in group},
                        modules=self.modules,
                        repeats=self.repeats,
                        limit_s=self.limit_s,
                        real_time_hz=self.real_time_hz,
                        out=out,
                        editions={name: self._editions(episode, name) for name in group if out is not None},
                        keeper=self.keeper,
                    )


Progress = Callable[[int, int], None]
"""Called with the number of (tracker, episode) pairs done, and of all."""
ShowProgress = Callable[[str], AbstractContextManager[Progress | None]]
"""Takes a title and opens what shows progress, e.g. ``benchmarks.show.progress.progress_bar``."""


def run(experiment: Experiment, out: Path, progress: Progress = lambda done, of: None) -> Outcome:
    """Run the missing episodes, write rows as they arrive, then the summary.

    The same call after a stop continues. Rows of other editions or parameters are moved to another file and made
    again, and so are rows without the estimates that are asked for. Except for times, ``workers`` changes no row.

    Raises:
        ValueError: for a folder that holds rows of other seeds or of another ``real_time_hz``, cannot be written, or is
            written by another run; and if there is no row at the end.
    """
    make_folder(out)
    try:
        with alone_in(out):
            return _run(experiment, out, progress)
    finally:
        if any(isinstance(each, ProcessTracker) for each in experiment.trackers.values()):
            end_workers(experiment.workers)


def _run(experiment: Experiment, out: Path, progress: Progress) -> Outcome:
    have, moved = _kept(experiment, out)
    outcome = Outcome(resumed=len(have), moved=moved)
    failures = {
        key: each for key, each in read_failures(out).items() if key in have or experiment.made_now(key) is None
    }
    write_failures(out, failures)
    outcome.failures += (earlier(each) for key in sorted(have & failures.keys()) for each in failures[key])
    # The command that repeats the run names it.
    limited: Row = {} if experiment.limit_s == Experiment.limit_s else {"limit_s": experiment.limit_s}
    progress(outcome.resumed, experiment.block_count)
    # Workers of an earlier run may have been started in another folder.
    jobs = experiment.jobs(out.resolve(), have)
    for job, result in results(jobs, experiment.workers):
        # Before the rows: failures without rows are dropped, rows without their failures would be taken for good ones.
        if result.failures:
            for failure in result.failures:
                name = failure.tracker if failure.tracker in job.trackers else next(iter(job.trackers))
                failures.setdefault(job.key(name), []).append(failure)
            write_failures(out, failures)
        for block in result.blocks:
            append_block(out, [row | limited for row in block])
        outcome = outcome.followed_by(result)
        progress(outcome.resumed + outcome.episodes, experiment.block_count)
    # A recording is unusable to each of its trackers.
    outcome.unusable = list(dict.fromkeys(outcome.unusable))
    with contextlib.suppress(OSError):
        (out / ".running").rmdir()
    if not (out / FILE_NAME).is_file():
        raise ValueError(_why_no_row(experiment, outcome))
    # Workers finish in any order; the file has a canonical one.
    outcome.moved += filter(None, [tidy(out)])
    outcome.summary = write_summary(out)
    return outcome


def _kept(experiment: Experiment, out: Path) -> tuple[set[BlockKey], list[str]]:
    """Return the blocks in a folder that need not be made, and messages about those that are moved to another file.

    So are rows of other trackers on what is real and has changed or is gone: they would be compared with rows on what
    it is now.
    """
    if not (out / FILE_NAME).is_file():
        return set(), []
    real = {(each.preset, each.seed): each for each in experiment.episodes if each.scenario is None}
    presets = {preset for preset, _ in real}

    def has_changed(key: BlockKey, row: Row) -> bool:
        if (key.suite, key.scenario) != (experiment.suite.name, REAL) or key.preset not in presets:
            return False
        episode = real.get((key.preset, key.seed))
        return episode is None or row.get("editions", {}).get("scene") != episode.edition

    seeds = None if real else {each.seed for each in experiment.episodes}
    have, moved = up_to_date(
        out, experiment.made_now, seeds, has_changed, experiment.run_count, experiment.real_time_hz
    )
    if experiment.keeper is not None:
        have = {key for key in have if experiment.keeper.is_kept(out / ESTIMATES, key, experiment.made_now(key))}
    return have, moved


def _why_no_row(experiment: Experiment, outcome: Outcome) -> str:
    if outcome.failures:
        return f"trackers: expected some that can begin, got {next(outcome.failures_in_words())}"
    expected = f"trackers: expected some with a gap method, got {', '.join(experiment.trackers)}"
    return next(iter(outcome.unusable), expected)
