"""One job of an experiment: one episode, opened once for all of its trackers, in a worker process."""

from __future__ import annotations

import hashlib
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import cv2
import numba

from benchmarks.contract.judging import Judge, Score, ScoreSheet, TimeBlock, UnreadableSequence
from benchmarks.contract.rows import ESTIMATES, LAST_METRIC, BlockKey, Row, rounded
from benchmarks.contract.suite import Suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.editions import Editions
from benchmarks.run.episodes import EpisodeSpec
from benchmarks.run.failures import Failure
from benchmarks.run.guards import Guard, GuardedController, GuardedTracker
from benchmarks.run.keeping import Keeper
from benchmarks.run.notes import Note, note_at
from benchmarks.run.outcome import AnswerWatch, Oddities
from scenarios.loop import Loop, tracker_stream
from scenarios.scenario import Frame
from scenarios.truth import Truth, TruthExtent, check_truth
from sim.checks import check

CONTROLLER_FAILED_AT = "controller_failed_at_frame"


@dataclass(frozen=True)
class Job:
    """An episode and its trackers, run by one worker.

    Attributes:
        suite: judges.
        episode: is opened once. Its controller steers by the (then only) tracker.
        trackers: name in rows → the tracker.
        modules: users' own modules that the run imported.
        repeats: runs of a tracker whose random numbers no seed reaches.
        limit_s: of CPU time of a tracker for one frame, see ``time_limit.at_most``.
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
    repeats: int = 3
    limit_s: float = 60.0
    out: Path | None = None
    editions: Mapping[str, Editions] = field(default_factory=dict)
    keeper: Keeper | None = None
    deadly: Mapping[str, int] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Short name, unique within an experiment."""
        keys = (self.key(tracker) for tracker in self.trackers or ("",))
        return hashlib.sha256(repr(tuple(keys)).encode()).hexdigest()[:16]

    @property
    def note_file(self) -> Path | None:
        """Path of the job's note while it runs."""
        return None if self.out is None else self.out / ".running" / f"{self.name}.json"

    def key(self, tracker: str) -> BlockKey:
        """Return the key of a tracker's block of rows."""
        return key_of(self.suite, self.episode, tracker)


def key_of(suite: Suite, episode: EpisodeSpec, tracker: str) -> BlockKey:
    """Return the key of the block of rows of a tracker in an episode; of a recording all blocks are one, of seed 0."""
    steering = episode.steering
    return BlockKey(
        suite.name,
        episode.scenario_id,
        episode.preset,
        episode.renderer,
        "" if steering is None else steering.name,
        tracker,
        episode.seed,
        "" if steering is None else steering.link or "",
    )


@dataclass(frozen=True)
class JobResult:
    """The result of a job.

    Attributes:
        name: of the job.
        blocks: rows, a block for each tracker; of tracks one for each block of time. There is no block of a tracker of
            which a package is missing.
        failures: trackers that failed.
        silent: tracker → number of frames without an answer.
        oddities: of the answers, and what is left running.
        unusable: why there is no row about this recording; "" if there are some.
    """

    name: str
    blocks: list[list[Row]] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    silent: Counter[str] = field(default_factory=Counter)
    oddities: Oddities = field(default_factory=Oddities)
    unusable: str = ""


@dataclass
class TrackerRun:
    """One run of one tracker in the job's episode."""

    name: str
    spec: TrackerSpec
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
        """Return which objects are targets in the job's suite."""
        scenario = self.job.episode.scenario
        assert scenario is not None
        return self.job.suite.targets(scenario, truth)

    def failures(self) -> list[Failure]:
        """Return the failures so far."""
        guards: list[tuple[str, Guard, str]] = [(each.name, each.guard, "answered nothing") for each in self.runs]
        episode = self.job.episode
        if self.controller is not None and episode.steering is not None:
            guards.insert(0, (episode.steering.name, self.controller, "commanded nothing"))
        where = (episode.scenario_id, episode.preset, episode.seed)
        return [
            Failure(name, *where, guard.failed_at_frame, str(guard.reason), since, guard.place, episode.sequence)
            for name, guard, since in guards
            if guard.failed_at_frame is not None
        ]


@contextmanager
def opened(job: Job, truth: TruthExtent = "all", note: Note | None = None) -> Iterator[OpenJob]:
    """Open a job's episode with fresh trackers and a fresh controller; free it at the end.

    Scoring and videos both run a job from here, so that they get the same pictures, estimates and commands.

    Raises:
        ValueError: for unknown names, a negative seed, or a controller without a tracker.
        UnreadableSequence: if the first picture of a real sequence is broken.
    """
    steering = job.episode.steering
    steered = None if steering is None else steering.name
    check("tracker", steering is None or bool(job.trackers), f"a name, as {steered!r} steers by one", "none")
    controller = None
    if steering is not None:
        _ = steering.entry  # An unknown name is refused before the episode is built.
    episode, runs = job.episode.open(truth), list[TrackerRun]()
    try:
        if steering is not None:
            controller = GuardedController(steering.create, job.limit_s, **_known_of(job, steering.name, note))
        many = job.suite.follows_many and (job.episode.scenario is not None or episode.frame_count == 0)
        for name, spec in job.trackers.items():
            for repeat in range(1 if spec.reproducible else job.repeats):
                rng = tracker_stream(job.episode.seed, spec.name, repeat)
                create = partial(spec.create, episode, job.episode.scenario, rng, many=many)
                how = {"needs_depth": job.suite.needs_depth, **_known_of(job, name, note)}
                runs.append(TrackerRun(name, spec, repeat, GuardedTracker(create, job.limit_s, many=many, **how)))
        link = job.episode.command_link(episode)
        yield OpenJob(job, Loop(episode, [each.guard for each in runs], link), runs, controller)
    finally:
        episode.close()
        for guard in (*(each.guard for each in runs), *([] if controller is None else [controller])):
            guard.close()


def run_job(job: Job) -> JobResult:
    """Run the job's episode and return the rows of all its trackers. Deterministic except for times."""
    # Times are of one core.
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    started = time.perf_counter()
    try:
        with note_at(job.note_file) as note, opened(job, job.suite.truth, note) as live:
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
    except UnreadableSequence as error:
        return JobResult(job.name, unusable=str(error))
    return replace(result, oddities=result.oddities + _left_running(live))


def take_in(loop: Loop, judge: Judge, sheets: Sequence[ScoreSheet]) -> None:
    """Pass a loop's latest frame to the judge and to the trackers' ``sheets``, in order."""
    judge.see(loop.frame, loop.obeyed)
    for sheet, answer in zip(sheets, loop.answers, strict=True):
        sheet.keep(loop.frame, answer)


def _known_of(job: Job, name: str, note: Note | None) -> dict[str, Any]:
    """Return ``how`` a guard notes what runs, and what earlier attempts have noted, see ``Guard``."""
    known: dict[str, Any] = {"ends_process_at": job.deadly.get(name)}
    return known if note is None else known | {"note": partial(note.write, name)}


def _result(live: OpenJob, sheets: Sequence[ScoreSheet], seconds: float) -> JobResult:
    job, episode = live.job, live.loop.episode
    blocks: list[list[Row]] = []
    silent, oddities, unusable = Counter[str](), Oddities(), ""
    controller_failed_at = None if live.controller is None else live.controller.failed_at_frame
    for name, group in groupby(zip(live.runs, sheets, strict=True), key=lambda pair: pair[0].name):
        own = list(group)
        guards = [run.guard for run, _ in own]
        if any(map(_lacks_package, guards)):
            continue
        if episode.frame_count == 0 and guards[0].gap_method is None and guards[0].reason is None:
            oddities.add(name, AnswerWatch(), ["has no gap_method and so no row"])
            continue
        scores = [
            (run.repeat, score)
            for run, sheet in own
            for score in (*sheet.scores(run.guard.ending()), *run.guard.scores())
        ]
        if controller_failed_at is not None:
            scores.append((0, Score(CONTROLLER_FAILED_AT, float(controller_failed_at))))
        made = _blocks(job, own[0][0], scores, episode.frame_count, seconds)
        if not made and guards[0].reason is None:
            unusable = f"{job.episode.preset}: expected tracks that are long enough for gaps, got none that is"
        blocks += made
        silent[name] += sum(guard.silent_frames for guard in guards if guard.reason is None)
    return JobResult(job.name, blocks, live.failures(), silent, oddities, unusable)


def _blocks(
    job: Job, run: TrackerRun, scores: Sequence[tuple[int, Score]], frame_count: int, seconds: float
) -> list[list[Row]]:
    """Return the rows of a tracker's scores: a block, or one for each block of time of a recording."""
    heading = heading_of(job, run.name)
    ending = {"seconds": seconds, "editions": job.editions.get(run.name, {})}
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


def _lacks_package(guard: Guard) -> bool:
    """Return whether a tracker could not begin, as a package is not installed: that is no figure of the method."""
    return guard.failed_at_frame == 0 and issubclass(guard.error or type(None), ModuleNotFoundError)


def _left_running(live: OpenJob) -> Oddities:
    """Return what was odd about the trackers of a closed episode."""
    found = Oddities()
    for each in live.runs:
        found.add(each.name, each.guard.watch, each.guard.left)
    if live.controller is not None and live.job.episode.steering is not None:
        found.add(live.job.episode.steering.name, AnswerWatch(), live.controller.left)
    return found


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
    }
    if job.modules:
        # The command that repeats the run names them.
        heading["modules"] = list(job.modules)
    if job.suite.judges_controllers and steering is not None:
        # A pair with a blind tracker sees nothing, and one with an oracle sees all, whatever its controller.
        heading["role"] = role if role in ("blind", "oracle") else controller_role or steering.entry.role
        heading |= {"tracker_role": role, "link": steering.link}
    return heading
