"""One job of an experiment: one episode, made once, with everyone who watches it. Runs in a worker
process.
"""

from __future__ import annotations

import hashlib
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numba

from benchmarks.run.contestants import Entrant, entrant, load_modules
from benchmarks.run.notes import Note, note_at
from benchmarks.run.records import LAST_METRIC, Row, rounded
from benchmarks.run.steering import Steering
from benchmarks.run.tracked import Failure, TrackedEpisode
from benchmarks.suites.judging import Judge, Score
from benchmarks.suites.registry import suite
from scenarios import catalog
from scenarios.command_link import CommandLink, link_named
from scenarios.scenario import Episode, Frame, RendererName
from sim.rng import generator
from trackers.controllers import catalogue
from trackers.types import Carrier, Estimate


@dataclass(frozen=True)
class Job:
    """What one worker does at a time.

    Attributes:
        suite, scenario, preset, renderer, seed: which episode.
        controller: who steers the camera by the (then only) tracker; None = the set path.
        controller_values: values of its parameters, other than those it was tuned to.
        trackers: who watches.
        link: how commands reach the camera's carrier, see ``scenarios.command_link``; None = as they are given.
        modules: users' own modules to import first.
        repeats: runs of a tracker whose random numbers no seed reaches.
        limit_s: the longest a tracker may take over a frame.
        notes: folder for the note that says what the worker is at, so that its death can be explained; None = no note.
        versions: tracker → what its rows say of their making, as it was when the experiment began.
        settings: label in ``trackers`` → the tracker's name and the values it is set to.
        deadly: trackers that ended their process in this episode, and the frame they did it on.
    """

    suite: str
    scenario: str
    preset: str
    renderer: RendererName
    seed: int
    controller: str | None
    trackers: tuple[str, ...]
    controller_values: dict[str, Any] = field(default_factory=dict)
    link: str | None = None
    modules: tuple[str, ...] = ()
    repeats: int = 3
    limit_s: float = 60.0
    notes: Path | None = None
    versions: dict[str, dict[str, str]] = field(default_factory=dict)
    settings: dict[str, tuple[str, dict[str, Any]]] = field(default_factory=dict)
    deadly: dict[str, int] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """What tells the job from the others of an experiment, short."""
        episode = (self.scenario, self.preset, self.renderer, str(self.seed), self.controller or "", self.link or "")
        return hashlib.sha256("/".join((*episode, *self.trackers)).encode()).hexdigest()[:16]

    @property
    def note_file(self) -> Path | None:
        """Where the job's note is while it runs."""
        return None if self.notes is None else self.notes / f"{self.name}.json"


@dataclass(frozen=True)
class JobResult:
    """What a job gives back.

    Attributes:
        job: the job.
        blocks: rows, a block for each tracker.
        failures: trackers that failed.
        silent: tracker → number of frames on which it said nothing.
    """

    job: Job
    blocks: list[list[Row]]
    failures: list[Failure]
    silent: dict[str, int]


@dataclass
class _Watcher:
    """One run of one tracker in the job's episode."""

    label: str
    entrant: Entrant
    repeat: int
    tracked: TrackedEpisode


def run_job(job: Job) -> JobResult:
    """Live through the job's episode and return everyone's rows. Deterministic but for times."""
    # Times are those of one core.
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(job.modules)
    scenario = catalog.scenario(job.scenario)
    started = time.perf_counter()
    with note_at(job.note_file) as note:
        episode = scenario.episode(
            job.preset,
            job.seed,
            renderer=job.renderer,
            closed_loop=job.controller is not None,
            truth=suite(job.suite).truth,
        )
        try:
            judge = suite(job.suite).judge(episode, scenario.carrier)
            watchers = _watchers(job, episode, judge)
            steering = _steering(job, episode, scenario.carrier)
            _live_through(job, episode, judge, watchers, steering, note)
        finally:
            episode.close()
    seconds = round((time.perf_counter() - started) / max(len(job.trackers), 1), 3)
    return _result(job, episode.frame_count, watchers, steering, seconds)


def _watchers(job: Job, episode: Episode, judge: Judge) -> list[_Watcher]:
    watchers = []
    for name in job.trackers:
        who = entrant(*job.settings.get(name, (name,)))
        for repeat in range(1 if who.reproducible else job.repeats):
            stream = f"tracker/{who.name}" if repeat == 0 else f"tracker/{who.name}/{repeat}"
            contestant = who.create(episode, generator(job.seed, stream))
            watchers.append(_Watcher(name, who, repeat, TrackedEpisode(contestant, judge.sheet(), job.limit_s)))
    return watchers


def _steering(job: Job, episode: Episode, carrier: Carrier) -> Steering | None:
    if job.controller is None:
        return None
    entry = catalogue.controller_entry(job.controller, carrier.name)
    if job.link is None:
        # Suites of trackers have one controller for all: the paper's, as it was written.
        return Steering(entry.create_as_written(), None, job.limit_s)
    link = CommandLink(carrier, episode.rate_hz, link_named(job.link), generator(job.seed, "link"))
    return Steering(entry.create(**job.controller_values), link, job.limit_s)


def _live_through(
    job: Job, episode: Episode, judge: Judge, watchers: list[_Watcher], steering: Steering | None, note: Note
) -> None:
    frame, command = episode.step(), None
    estimates: list[Estimate] = []
    for k in range(episode.frame_count):
        if k > 0:
            if steering is not None:
                command = steering.command(frame.observation, estimates[0])
            frame = episode.step(command)
        judge.see(frame, command)
        estimates = [_watch(job, watcher, frame, episode, note) for watcher in watchers]


def _watch(job: Job, watcher: _Watcher, frame: Frame, episode: Episode, note: Note) -> Estimate:
    name, k = watcher.label, frame.truth.frame
    if job.deadly.get(name) == k:
        watcher.tracked.fail("ended its process (killed, crashed or stuck in compiled code)")
    note.write(name, k)
    return watcher.tracked.step(frame, episode.target_box_xyxy)


def _result(
    job: Job, frame_count: int, watchers: list[_Watcher], steering: Steering | None, seconds: float
) -> JobResult:
    blocks: list[list[Row]] = []
    failures: list[Failure] = []
    silent: dict[str, int] = {}
    event_key = suite(job.suite).events.key
    if steering is not None and steering.failed_at_frame is not None:
        where = (str(job.controller), job.scenario, job.preset, job.seed, steering.failed_at_frame)
        failures.append(Failure(*where, str(steering.reason), since="commanded nothing"))
    for name in job.trackers:
        mine = [watcher for watcher in watchers if watcher.label == name]
        heading = heading_of(job, name, mine[0].entrant.role)
        ending = {"seconds": seconds, "versions": job.versions.get(name, {})}
        scores = [(watcher.repeat, score) for watcher in mine for score in watcher.tracked.scores()]
        if steering is not None and steering.failed_at_frame is not None:
            scores.append((0, Score("controller_failed_at_frame", float(steering.failed_at_frame))))
        scores.append((0, Score(LAST_METRIC, float(frame_count))))
        blocks.append([{**heading, **as_row(repeat, score, event_key), **ending} for repeat, score in scores])
        for watcher in mine:
            tracked = watcher.tracked
            if tracked.reason is not None and tracked.failed_at_frame is not None:
                where = (name, job.scenario, job.preset, job.seed, tracked.failed_at_frame)
                failures.append(Failure(*where, tracked.reason))
            else:
                silent[name] = silent.get(name, 0) + tracked.silent_frames
    return JobResult(job, blocks, failures, silent)


def heading_of(job: Job, tracker: str, tracker_role: str, controller_role: str | None = None) -> Row:
    """Return what all rows of a tracker's block begin with; the controller's role is the catalogue's unless given."""
    heading: Row = {
        "suite": job.suite,
        "scenario": catalog.scenario(job.scenario).id,
        "preset": job.preset,
        "tracker": tracker,
        "role": tracker_role,
        "controller": job.controller,
        "renderer": job.renderer,
        "seed": job.seed,
    }
    if suite(job.suite).judges_controllers:
        carrier = catalog.scenario(job.scenario).carrier.name
        heading["role"] = controller_role or catalogue.controller_entry(str(job.controller), carrier).role
        heading |= {"tracker_role": tracker_role, "link": job.link}
    return heading


def as_row(repeat: int, score: Score, event_key: str) -> Row:
    """Return what a row says of a score."""
    return {
        "repeat": repeat,
        "metric": score.metric,
        "value": rounded(score.value),
        "weight": score.weight,
        event_key: None if score.event is None else score.event.attributes(),
    }
