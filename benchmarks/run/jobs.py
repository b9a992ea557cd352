"""One job of an experiment: one episode, opened once for all of its trackers, in a worker process."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import cv2
import numba

from benchmarks.contract.judging import Judge, Score, ScoreSheet, TimeBlock, UnreadableSequence
from benchmarks.contract.metric import BrokenMetric
from benchmarks.contract.rows import ESTIMATES, LAST_METRIC, BlockKey, Row, rounded
from benchmarks.contract.suite import Suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.editions import Editions
from benchmarks.run.episodes import EpisodeSpec
from benchmarks.run.failures import Failure
from benchmarks.run.guards import Guard, GuardedController, GuardedTracker
from benchmarks.run.outcome import Outcome
from benchmarks.run.own_modules import users_line
from benchmarks.run.real_time import RealTimeTracker
from scenarios.loop import Loop, tracker_stream
from scenarios.scenario import Frame
from scenarios.truth import Truth, TruthExtent, check_truth
from sim.checks import check

CONTROLLER_FAILED_AT = "controller_failed_at_frame"
USUAL_REPEATS = 3


class KeepingJudge(Judge, Protocol):
    """A judge that keeps what it passes on to another one."""

    def write(self, folder: Path, blocks: Sequence[list[Row]], trackers: Sequence[tuple[str, GuardedTracker]]) -> None:
        """Write a file for each of the judged ``blocks``, after their scores; ``trackers``: in the sheets' order."""
        ...


class Keeper(Protocol):
    """Keeps all answers of a run beside its rows."""

    def judge(self, judge: Judge) -> KeepingJudge:
        """Return a judge of an episode that keeps what it passes on to ``judge``."""
        ...

    def is_kept(self, folder: Path, key: BlockKey, editions: dict[str, str] | None) -> bool:
        """Return whether a block has a whole file, of these ``editions``."""
        ...


@dataclass(frozen=True)
class Job:
    """An episode and its trackers, run by one worker.

    Attributes:
        suite: judges.
        episode: is opened once. Its controller steers by the (then only) tracker.
        trackers: name in rows → the tracker.
        modules: users' own modules that the run imported.
        repeats: runs of each tracker, each with random numbers of its own; None = ``USUAL_REPEATS`` of one whose random
            numbers no seed reaches, else 1.
        limit_s: of CPU time of a tracker for one frame, see ``time_limit.at_most``.
        real_time_hz: pictures a second, see ``run.real_time``; None = they wait for the trackers.
        out: folder of the rows, where the worker keeps a note that explains a crash, and ``keeper`` all answers; None
            = no note.
        editions: tracker → ``editions`` of its rows, read once for an experiment.
        keeper: keeps all answers; None = they are not kept.
        deadly: tracker that ended its process in this episode → frame.
    """

    suite: Suite
    episode: EpisodeSpec
    trackers: Mapping[str, TrackerSpec]
    modules: tuple[str, ...] = ()
    repeats: int | None = None
    limit_s: float = 60.0
    real_time_hz: float | None = None
    out: Path | None = None
    editions: Mapping[str, Editions] = field(default_factory=dict)
    keeper: Keeper | None = None
    deadly: Mapping[str, int] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Short name, unique within an experiment."""
        keys = tuple(self.key(tracker) for tracker in self.trackers or ("",))
        return hashlib.sha256(repr(keys).encode()).hexdigest()[:16]

    @property
    def note_file(self) -> Path | None:
        """Path of the job's note while it runs."""
        return None if self.out is None else self.out / ".running" / self.name

    def key(self, tracker: str) -> BlockKey:
        """Return the key of a tracker's block of rows."""
        return key_of(self.suite, self.episode, tracker)


def run_count(tracker: TrackerSpec, repeats: int | None) -> int:
    """Return how often a tracker runs in an episode, see ``Job.repeats``."""
    return repeats or (1 if tracker.reproducible else USUAL_REPEATS)


def key_of(suite: Suite, episode: EpisodeSpec, tracker: str) -> BlockKey:
    """Return the key of the block of rows of a tracker in an episode; of a recording all blocks are one, of seed 0."""
    steering = episode.steering
    by, link = ("", "") if steering is None else (steering.name, steering.link or "")
    where = (episode.scenario_id, episode.preset, episode.renderer)
    return BlockKey(suite.name, *where, by, tracker, episode.seed, link)


@dataclass
class JobResult(Outcome):
    """The result of a job, as an ``Outcome``.

    Attributes:
        name: of the job.
        blocks: rows, a block for each tracker; of tracks one for each block of time. There is no block of a tracker of
            which a package is missing, or of a recording that is unusable.
    """

    name: str = ""
    blocks: list[list[Row]] = field(default_factory=list)


class TrackerRun(NamedTuple):
    """One run of one tracker in the job's episode."""

    name: str
    repeat: int
    guard: GuardedTracker


@dataclass(frozen=True)
class OpenJob:
    """A job's episode before its first frame, with trackers and controller.

    Attributes:
        job: the job.
        loop: through the episode. runs: its trackers, in order.
        controller: steers the camera; None on a set path.
    """

    job: Job
    loop: Loop
    runs: list[TrackerRun]
    controller: GuardedController | None

    def frames(self, count: int | None = None) -> Iterator[Frame]:
        """Step through the first ``count`` frames, None = all."""
        return self.loop.frames(self.controller, count)

    def targets(self, truth: Truth) -> tuple[int, ...]:
        """Return which objects are targets in the job's suite; of what is real all whose truth is known."""
        scenario = self.job.episode.scenario
        return tuple(range(len(truth.names))) if scenario is None else self.job.suite.targets(scenario, truth)

    def guards(self) -> list[tuple[str, Guard]]:
        """Return the guards of controller and trackers, with the names of these."""
        steering = self.job.episode.steering
        steered = [] if steering is None or self.controller is None else [(steering.name, self.controller)]
        return [*steered, *((each.name, each.guard) for each in self.runs)]

    def failures(self) -> list[Failure]:
        """Return the failures so far."""
        at = self.job.episode
        where = (at.scenario_id, at.preset, at.seed)
        return [
            Failure(name, *where, guard.failed_at_frame, str(guard.reason), guard.since, guard.place, at.sequence)
            for name, guard in self.guards()
            if guard.failed_at_frame is not None
        ]


@contextmanager
def opened(
    job: Job, truth: TruthExtent = "all", note: Callable[[str, int], object] = lambda name, frame: None
) -> Iterator[OpenJob]:
    """Open a job's episode with fresh trackers and a fresh controller; free it at the end.

    Scoring and videos both run a job from here, so that they get the same pictures, estimates and commands.

    Args:
        note: is called with the name of what comes next, and the frame.

    Raises:
        ValueError: for unknown names, a negative seed, or a controller without a tracker.
        UnreadableSequence: if the first picture of a real sequence is broken.
    """

    def how(name: str) -> dict[str, Any]:
        return {"limit_s": job.limit_s, "note": partial(note, name), "ends_process_at": job.deadly.get(name)}

    steering = job.episode.steering
    if steering is not None:
        check("tracker", bool(job.trackers), f"a name, as {steering.name!r} steers by one", "none")
        _ = steering.entry  # An unknown name is refused before the episode is built.
    guarded = partial(RealTimeTracker, rate_hz=job.real_time_hz) if job.real_time_hz else GuardedTracker
    controller: GuardedController | None = None
    runs: list[TrackerRun] = []
    episode = job.episode.open(truth)
    try:
        if steering is not None:
            controller = GuardedController(partial(steering.create, job.episode), **how(steering.name))
        many = job.suite.follows_many and not job.episode.has_one_target
        for name, spec in job.trackers.items():
            for repeat in range(run_count(spec, job.repeats)):
                rng = tracker_stream(job.episode.seed, spec.name, repeat)
                create = partial(spec.create, job.episode, episode, rng, many=many)
                limits = {"start_limit_s": spec.start_limit_s, "limit_s": spec.frame_limit_s or job.limit_s}
                its = how(name) | limits
                guard = guarded(create, many=many, needs_depth=job.suite.needs_depth, timed=spec.timed, **its)
                runs.append(TrackerRun(name, repeat, guard))
        link = job.episode.command_link(episode)
        guards = [each.guard for each in runs]
        yield OpenJob(job, Loop(episode, guards, link, job.episode.picture_delay_frames), runs, controller)
    finally:
        episode.close()
        for each in filter(None, [*(each.guard for each in runs), controller]):
            each.close()


@contextmanager
def _noting(file: Path | None) -> Iterator[Callable[[str, int], object]]:
    """Keep a note of what runs in a file (None = none) during the context; only a crashed process leaves it behind."""
    if file is None:
        yield lambda name, frame: None
        return
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("wb", buffering=0) as note:
        try:
            # One write in place takes some microseconds.
            yield lambda name, frame: os.pwrite(note.fileno(), f"{frame} {name}\n".encode(), 0)
        finally:
            file.unlink(missing_ok=True)


def read_note(file: Path | None) -> tuple[str, int] | None:
    """Return what ran, and the frame, of a note left behind; None without a note or with an empty one."""
    if file is None or not file.is_file():
        return None
    # Below the first line is what a longer note has left.
    frame, _, name = file.read_bytes().partition(b"\n")[0].decode().partition(" ")
    return (name, int(frame)) if frame else None


def run_job(job: Job) -> JobResult:
    """Run the job's episode and return the rows of all its trackers. Deterministic except for times.

    Raises:
        ValueError: for a metric whose function raises or returns no value of it; names the episode and its line.
    """
    # Times are of one core.
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    started = time.perf_counter()
    try:
        with _noting(job.note_file) as note, opened(job, job.suite.truth, note) as live:
            episode = live.loop.episode
            judge: Judge = job.episode.judge(job.suite, episode)
            keeping = None if job.keeper is None else job.keeper.judge(judge)
            judge = keeping or judge
            sheets = [judge.sheet() for _ in live.runs]
            for frame in live.frames() if episode.frame_count else ():
                if frame.truth.frame == 0:
                    check_truth(frame.truth)
                take_in(live.loop, judge, sheets)
            seconds = round((time.perf_counter() - started) / max(len(job.trackers), 1), 3)
            result = _result(live, sheets, seconds)
            if keeping is not None and job.out is not None:
                keeping.write(job.out / ESTIMATES, result.blocks, [(each.name, each.guard) for each in live.runs])
    except BrokenMetric as error:
        line = users_line(error.__cause__) if error.__cause__ else None
        place = f" ({Path(line[0]).name}, line {line[1]})" if line else ""
        raise ValueError(f"{error}{place}, in {job.episode.in_words}") from None
    except UnreadableSequence as error:
        return JobResult(name=job.name, episodes=len(job.trackers), unusable=[str(error)])
    # Of several runs of a tracker each oddity counts once.
    result.oddities.update({(name, what): 1 for name, guard in live.guards() for what in guard.oddities})
    return result


def take_in(loop: Loop, judge: Judge, sheets: Sequence[ScoreSheet]) -> None:
    """Pass a loop's latest frame to the judge and to the trackers' ``sheets``, in order."""
    judge.see(loop.frame, loop.obeyed)
    for sheet, answer in zip(sheets, loop.answers, strict=True):
        sheet.keep(loop.seen, answer)


def _result(live: OpenJob, sheets: Sequence[ScoreSheet], seconds: float) -> JobResult:
    job, frame_count = live.job, live.loop.episode.frame_count
    result = JobResult(name=job.name, episodes=len(job.trackers))
    controller_failed_at = None if live.controller is None else live.controller.failed_at_frame
    for name, group in groupby(zip(live.runs, sheets, strict=True), key=lambda pair: pair[0].name):
        own = list(group)
        guards = [run.guard for run, _ in own]
        if any(map(_lacks_package, guards)):
            continue
        whole = guards[0].reason is None
        if whole and frame_count == 0 and guards[0].gap_method is None:
            result.oddities[name, "has no gap_method and so no row"] += 1
            continue
        scores = [
            (run.repeat, score)
            for run, sheet in own
            for score in (*sheet.scores(run.guard.ending()), *run.guard.scores())
        ]
        if controller_failed_at is not None:
            scores.append((0, Score(CONTROLLER_FAILED_AT, float(controller_failed_at))))
        made = _blocks(job, name, scores, frame_count, seconds)
        if whole and not made:
            wanted = "expected tracks that are long enough for gaps, got none that is"
            result.unusable = [f"{job.episode.preset}: {wanted}"]
        result.blocks.extend(made)
        result.silent[name] += sum(guard.silent_frames for guard in guards if guard.reason is None)
    result.failures = live.failures()
    return result


def _lacks_package(guard: Guard) -> bool:
    """Return whether a tracker could not begin, as a package is not installed: that is no figure of the method."""
    return guard.failed_at_frame == 0 and issubclass(guard.error or type(None), ModuleNotFoundError)


def _blocks(
    job: Job, tracker: str, scores: Sequence[tuple[int, Score]], frame_count: int, seconds: float
) -> list[list[Row]]:
    """Return the rows of a tracker's scores: a block, or one for each block of time of a recording."""
    heading = heading_of(job, tracker)
    ending = {"seconds": seconds, "editions": job.editions.get(tracker, {})}
    if frame_count:
        return [block_of(job.suite, heading, scores, frame_count, ending)]
    of_time: dict[TimeBlock, list[tuple[int, Score]]] = {}
    for repeat, score in scores:
        if score.block is not None:
            of_time.setdefault(score.block, []).append((repeat, score))
    return [
        block_of(job.suite, heading | {"blocks": len(of_time), "seed": block.index}, own, block.frame_count, ending)
        for block, own in of_time.items()
    ]


def block_of(
    suite: Suite, heading: Row, scores: Sequence[tuple[int, Score]], frame_count: int, ending: Row
) -> list[Row]:
    """Return the rows of a block: of the scores of each repeat, and the last one, between ``heading`` and ``ending``,
    the columns that all of them have.
    """
    return [
        {
            **heading,
            "repeat": repeat,
            "metric": score.metric,
            "value": rounded(score.value),
            "weight": score.weight,
            suite.events.key: None if score.event is None else score.event.attributes(),
            **ending,
        }
        for repeat, score in (*scores, (0, Score(LAST_METRIC, float(frame_count))))
    ]


def heading_of(job: Job, tracker: str, controller_role: str | None = None) -> Row:
    """Return the common columns of a tracker's block; the controller's role is the registered one unless given."""
    episode, role = job.episode, job.trackers[tracker].role
    steering = episode.steering
    heading: Row = {
        "suite": job.suite.name,
        "scenario": episode.scenario_id,
        "preset": episode.preset,
        "tracker": tracker,
        "role": role,
        "controller": None if steering is None else steering.name,
        "renderer": episode.renderer,
        "seed": episode.seed,
        **episode.columns,
        **job.trackers[tracker].columns,
    }
    if job.real_time_hz is not None:
        heading["real_time_hz"] = job.real_time_hz
    if job.modules:
        # The command that repeats the run names them.
        heading["modules"] = list(job.modules)
    if job.suite.judges_controllers and steering is not None:
        # A pair with a blind tracker sees nothing, and one with an oracle sees all, whatever its controller.
        heading["role"] = role if role in ("blind", "oracle") else controller_role or steering.entry.role
        heading |= {"tracker_role": role, "link": steering.link}
    return heading
