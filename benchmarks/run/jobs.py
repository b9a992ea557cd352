"""One job of an experiment: one episode, simulated or read once for all of its trackers, in a worker process."""

from __future__ import annotations

import hashlib
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, cast

import cv2
import numba

from benchmarks.contract.judging import Ending, Judge, Recording, Score, ScoreSheet, UnreadableSequence
from benchmarks.contract.rows import REAL, Row
from benchmarks.contract.suite import suite
from benchmarks.run.blocks import as_block
from benchmarks.run.contestants import Entrant, contestant_of_one, entrant, gap_method_of
from benchmarks.run.failures import Failure
from benchmarks.run.guards import Guard, GuardedContestant, GuardedController, GuardedGapMethod, guarded
from benchmarks.run.keeping import Keeper
from benchmarks.run.notes import Note, note_at
from benchmarks.run.oddities import AnswerWatch, Oddities
from benchmarks.run.own_modules import load_modules
from benchmarks.run.real import RealEpisode
from benchmarks.run.steering import controller_maker
from scenarios import catalog
from scenarios.command_link import episode_link, link_named
from scenarios.loop import Contestant, Loop, tracker_stream
from scenarios.scenario import Episode, Frame, RendererName
from scenarios.truth import Truth, TruthExtent, check_truth
from sim.checks import check
from trackers.controllers import catalogue


@dataclass(frozen=True)
class Job:
    """An episode and its contestants, run by one worker.

    Attributes:
        suite, scenario, preset, renderer, seed: which episode.
        controller: name of the one that steers by the (then only) tracker; None = the set path.
        controller_values: parameter values in place of the tuned ones.
        trackers: labels of the contestants.
        link: how commands reach the camera's carrier, see ``scenarios.command_link``; None = unchanged.
        modules: users' own modules to import first.
        repeats: runs of a tracker whose random numbers no seed reaches.
        limit_s: of CPU time of a tracker for one frame, see ``time_limit.at_most``.
        notes: folder for the worker's note, which explains a crash; None = no note.
        editions: tracker → ``editions`` of its rows, from the start of the experiment.
        settings: label in ``trackers`` → the tracker's name and its parameter values.
        changes: the preset that ``preset`` is a change of, and its changed fields; None = ``preset`` as it is.
        stored: returns the stored episode of a seed; None = it is rendered.
        keeper: keeps all answers in the folder ``estimates``; None = they are not kept.
        deadly: tracker that ended its process in this episode → frame.
        real: what takes the episode's place; None = it is simulated. Scenario and renderer are then ``REAL``.
    """

    suite: str
    scenario: str
    preset: str
    renderer: RendererName | Literal["real"]
    seed: int
    controller: str | None
    trackers: tuple[str, ...]
    controller_values: dict[str, Any] = field(default_factory=dict)
    link: str | None = None
    modules: tuple[str, ...] = ()
    repeats: int = 3
    limit_s: float = 60.0
    notes: Path | None = None
    editions: dict[str, dict[str, str]] = field(default_factory=dict)
    settings: dict[str, tuple[str, dict[str, Any]]] = field(default_factory=dict)
    changes: tuple[str, dict[str, Any]] | None = None
    stored: Callable[[int], Episode] | None = None
    keeper: Keeper | None = None
    estimates: Path | None = None
    deadly: dict[str, int] = field(default_factory=dict)
    real: RealEpisode | None = None

    @property
    def sequence(self) -> str:
        """Name of the real sequence; "" without."""
        return "" if self.real is None else self.real.sequence

    @property
    def name(self) -> str:
        """Short name, unique within an experiment."""
        episode = (self.scenario, self.preset, self.renderer, str(self.seed), self.controller or "", self.link or "")
        return hashlib.sha256("/".join((*episode, *self.trackers)).encode()).hexdigest()[:16]

    @property
    def note_file(self) -> Path | None:
        """Path of the job's note while it runs."""
        return None if self.notes is None else self.notes / f"{self.name}.json"


@dataclass(frozen=True)
class JobResult:
    """The result of a job.

    Attributes:
        job: the job.
        blocks: rows, a block for each tracker; of tracks one for each block of time. There is no block of a tracker of
            which a package is missing.
        failures: trackers that failed.
        silent: tracker → number of frames without an answer.
        oddities: of the answers, and what is left running.
        unusable: why there is no row about this recording; "" if there are some.
    """

    job: Job
    blocks: list[list[Row]] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    silent: Counter[str] = field(default_factory=Counter)
    oddities: Oddities = field(default_factory=Oddities)
    unusable: str = ""


@dataclass
class _Watcher:
    """One run of one tracker in the job's episode."""

    label: str
    entrant: Entrant
    repeat: int
    guard: GuardedContestant


@dataclass(frozen=True)
class OpenJob:
    """A job's episode before its first frame, with contestants and controller.

    Attributes:
        job: the job.
        loop: through the episode. watchers: its contestants, in order.
        controller: steers the camera; None on a set path.
    """

    job: Job
    loop: Loop
    watchers: list[_Watcher]
    controller: GuardedController | None

    def frames(self, count: int | None = None) -> Iterator[Frame]:
        """Step through the first ``count`` frames, None = all."""
        return self.loop.frames(self.controller, count)

    def targets(self, truth: Truth) -> tuple[int, ...]:
        """Return which objects are targets in the job's suite."""
        return suite(self.job.suite).targets(catalog.scenario(self.job.scenario), truth)

    def failures(self) -> list[Failure]:
        """Return the failures so far."""
        guards: list[tuple[str, Guard, str]] = [(each.label, each.guard, "answered nothing") for each in self.watchers]
        if self.controller is not None:
            guards.insert(0, (str(self.job.controller), self.controller, "commanded nothing"))
        where = (self.job.scenario, self.job.preset, self.job.seed)
        return [
            Failure(name, *where, guard.failed_at_frame, str(guard.reason), since, guard.place, self.job.sequence)
            for name, guard, since in guards
            if guard.failed_at_frame is not None
        ]


@contextmanager
def opened(job: Job, truth: TruthExtent = "all", note: Note | None = None) -> Iterator[OpenJob]:
    """Build a job's episode with fresh trackers and a fresh controller; free it at the end.

    Scoring and videos both run a job from here, so that they get the same pictures, estimates and commands.

    Raises:
        ValueError: for unknown names, a negative seed, or a controller without a tracker.
    """
    steerable = job.controller is None or bool(job.trackers)
    check("tracker", steerable, f"a name, as {job.controller!r} steers by one", "none")
    controller = link = None
    if job.controller is not None:
        carrier = catalog.scenario(job.scenario).carrier
        create = controller_maker(job.controller, carrier.name, job.link, job.controller_values)
    episode, watchers = episode_of(job, truth), list[_Watcher]()
    try:
        if job.controller is not None:
            controller = GuardedController(create, job.limit_s, **_known_of(job, job.controller, note))
            if job.link is not None:
                link = episode_link(carrier, episode.rate_hz, link_named(job.link), job.seed)
        watchers += _watchers(job, episode, note)
        yield OpenJob(job, Loop(episode, [each.guard for each in watchers], link), watchers, controller)
    finally:
        episode.close()
        for guard in (*(each.guard for each in watchers), *([] if controller is None else [controller])):
            guard.close()


def episode_of(job: Job, truth: TruthExtent) -> Episode:
    """Return a job's episode before its first frame, rendered, stored or real.

    Raises:
        UnreadableSequence: if the first picture of a real one is broken.
    """
    if job.real is not None:
        assert job.real.open is not None
        return job.real.open()
    if job.stored is not None:
        return job.stored(job.seed)
    assert job.renderer != REAL
    steered = job.controller is not None
    scenario = catalog.scenario(job.scenario)
    preset, changed = job.changes or (job.preset, {})
    configuration = replace(scenario.presets[preset], **changed) if changed else preset
    return scenario.episode(configuration, job.seed, renderer=job.renderer, closed_loop=steered, truth=truth)


def job_of(row: Row, seed: int) -> Job:
    """Return the job that repeats the run of a row, on this ``seed``."""
    episode = (row["suite"], row["scenario"], row["preset"], row["renderer"], seed)
    modules = tuple(row.get("modules", ()))
    return Job(*episode, row["controller"], (row["tracker"],), link=row.get("link"), modules=modules, repeats=1)


def run_job(job: Job) -> JobResult:
    """Run the job's episode and return the rows of all its trackers. Deterministic except for times."""
    # Times are of one core.
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(job.modules)
    if job.real is not None and job.real.open is None:
        return _run_on_tracks(job, cast("Recording", job.real.content))
    try:
        return _run_on_pictures(job)
    except UnreadableSequence as error:
        return JobResult(job, unusable=str(error))


def _run_on_pictures(job: Job) -> JobResult:
    judging = suite(job.suite)
    started = time.perf_counter()
    with note_at(job.note_file) as note, opened(job, judging.truth, note) as live:
        judge = _judge_of(job, live.loop.episode)
        keeping = None if job.keeper is None else job.keeper.judge(judge)
        judge = keeping or judge
        sheets = [judge.sheet() for _ in live.watchers]
        for frame in live.frames():
            if frame.truth.frame == 0:
                check_truth(frame.truth)
            take_in(live.loop, judge, sheets)
        seconds = round((time.perf_counter() - started) / max(len(job.trackers), 1), 3)
        result = _result(live, sheets, seconds)
        if keeping is not None and job.estimates is not None:
            keeping.write(job.estimates, result.blocks, [(each.label, each.guard) for each in live.watchers])
    return replace(result, oddities=_oddities(live))


def _oddities(live: OpenJob) -> Oddities:
    """Return what was odd about the contestants of a closed episode."""
    found = Oddities()
    for each in live.watchers:
        found.add(each.label, each.guard.watch, each.guard.left)
    if live.controller is not None:
        found.add(str(live.job.controller), AnswerWatch(), live.controller.left)
    return found


def _judge_of(job: Job, episode: Episode) -> Judge:
    judging = suite(job.suite)
    if job.real is None:
        return judging.judge(episode, catalog.scenario(job.scenario))
    assert judging.on_sequences is not None
    return judging.on_sequences.judge(episode)


def _run_on_tracks(job: Job, recording: Recording) -> JobResult:
    """Ask the job's one tracker about gaps in tracks; no row if it has no method to bridge them."""
    (name,) = job.trackers
    started = time.perf_counter()
    blocks: list[tuple[int, Sequence[Score]]] = []
    with note_at(job.note_file) as note:
        guard = Guard(job.limit_s, "answer", **_known_of(job, name, note))
        method = guard.made(lambda: gap_method_of(name, tracker_stream(job.seed, name)))
        bridges = method is not None
        if method is not None:
            guard.begins(1)
            blocks = list(recording.scores(Ending(new_gap_method=partial(GuardedGapMethod, method, guard, 0))))
        # What ends its process when it is dropped is dropped before.
        del method
        guard.close()
    able = bridges or guard.reason is not None
    oddities = Oddities()
    oddities.add(name, AnswerWatch(), guard.left if able else [*guard.left, "has no gap_method and so no row"])
    seconds = round((time.perf_counter() - started) / max(len(blocks), 1), 3)
    heading = heading_of(job, name, entrant(name).role) | {"blocks": len(blocks)}
    ending = {"seconds": seconds, "editions": job.editions.get(name, {})}
    event_key, unusable = suite(job.suite).events.key, ""
    rows = [
        as_block(
            heading | {"seed": number},
            [(0, score) for score in scores],
            None,
            recording.block_frames,
            event_key,
            ending,
        )
        for number, scores in blocks
    ]
    if bridges and not rows:
        unusable = f"{recording.name}: expected tracks that are long enough for gaps, got none that is"
    failures = []
    if guard.reason is not None:
        where = (name, job.scenario, job.preset, job.seed, 0)
        failures.append(Failure(*where, guard.reason, "predicted nothing", guard.place))
    return JobResult(job, rows, failures, oddities=oddities, unusable=unusable)


def take_in(loop: Loop, judge: Judge, sheets: Sequence[ScoreSheet]) -> None:
    """Pass a loop's latest frame to the judge and to the contestants' ``sheets``, in order."""
    judge.see(loop.frame, loop.obeyed)
    for sheet, answer in zip(sheets, loop.answers, strict=True):
        sheet.keep(loop.frame, answer)


def _watchers(job: Job, episode: Episode, note: Note | None) -> list[_Watcher]:
    watchers = []
    judging = suite(job.suite)
    scenario = None if job.real is not None else catalog.scenario(job.scenario)
    many = scenario is not None and judging.follows_many
    for label in job.trackers:
        entered = entrant(*job.settings.get(label, (label,)))
        for repeat in range(1 if entered.reproducible else job.repeats):
            rng = tracker_stream(job.seed, entered.name, repeat)
            create: Callable[[], Contestant]
            if scenario is None:
                create = partial(contestant_of_one, label, rng)
            else:
                create = partial(entered.create, episode, scenario, rng, many)
            how = {"many": many, "needs_depth": judging.needs_depth} | _known_of(job, label, note)
            watchers.append(_Watcher(label, entered, repeat, guarded(create, job.limit_s, **how)))
    return watchers


def _known_of(job: Job, name: str, note: Note | None) -> dict[str, Any]:
    """Return ``how`` a guard notes what runs, and what earlier attempts have noted, see ``Guard``."""
    known: dict[str, Any] = {"ends_process_at": job.deadly.get(name)}
    return known if note is None else known | {"note": partial(note.write, name)}


def _result(live: OpenJob, sheets: Sequence[ScoreSheet], seconds: float) -> JobResult:
    job = live.job
    blocks: list[list[Row]] = []
    silent: Counter[str] = Counter()
    event_key = suite(job.suite).events.key
    controller_failed_at = None if live.controller is None else live.controller.failed_at_frame
    unequipped = {each.label for each in live.watchers if _lacks_package(each.guard)}
    for name in job.trackers:
        if name in unequipped:
            continue
        mine = [(each, sheet) for each, sheet in zip(live.watchers, sheets, strict=True) if each.label == name]
        heading = heading_of(job, name, mine[0][0].entrant.role)
        ending = {"seconds": seconds, "editions": job.editions.get(name, {})}
        scores = [
            (each.repeat, score)
            for each, sheet in mine
            for score in (*sheet.scores(each.guard.ending()), *each.guard.scores())
        ]
        frame_count = live.loop.episode.frame_count
        blocks.append(as_block(heading, scores, controller_failed_at, frame_count, event_key, ending))
    for each in live.watchers:
        if each.guard.reason is None:
            silent[each.label] += each.guard.silent_frames
    return JobResult(job, blocks, live.failures(), silent)


def _lacks_package(guard: Guard) -> bool:
    """Return whether a contestant could not begin, as a package is not installed: that is no figure of the method."""
    return guard.failed_at_frame == 0 and issubclass(guard.error or type(None), ModuleNotFoundError)


def heading_of(job: Job, tracker: str, tracker_role: str, controller_role: str | None = None) -> Row:
    """Return the common columns of a tracker's block; the controller's role is the catalogue's unless given."""
    heading: Row = {
        "suite": job.suite,
        "scenario": REAL if job.real is not None else catalog.scenario(job.scenario).id,
        "preset": job.preset,
        "tracker": tracker,
        "role": tracker_role,
        "controller": job.controller,
        "renderer": job.renderer,
        "seed": job.seed,
    }
    if job.real is not None:
        heading |= job.real.columns
    if job.modules:
        # The command that repeats the run names them.
        heading["modules"] = list(job.modules)
    if suite(job.suite).judges_controllers:
        carrier = catalog.scenario(job.scenario).carrier.name
        steering = controller_role or catalogue.controller_entry(str(job.controller), carrier).role
        # A pair with a blind tracker sees nothing, and one with an oracle sees all, whatever its controller.
        heading["role"] = tracker_role if tracker_role in ("blind", "oracle") else steering
        heading |= {"tracker_role": tracker_role, "link": job.link}
    return heading
