"""Runs a suite: everyone through every episode, on all cores, resumable, whatever a tracker does."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, get_args

from benchmarks.run.contestants import entrant, entrants, load_modules
from benchmarks.run.guards import Failure
from benchmarks.run.jobs import Job
from benchmarks.run.processes import results
from benchmarks.run.records import FILE_NAME, HUMAN, BlockKey, append_block, read_blocks, tidy
from benchmarks.run.steering import link_in
from benchmarks.run.versions import versions_of
from benchmarks.scores.summary import write_summary
from benchmarks.suites.registry import suite
from scenarios import catalog
from scenarios.command_link import LINKS
from scenarios.scenario import RendererName
from trackers import registry
from trackers.controllers import catalogue

SET_PATH = "set-path"
_NOTES = ".running"


@dataclass(frozen=True)
class Experiment:
    """What is run.

    Attributes:
        suite: name of the suite whose metrics count.
        scenario: catalogue id. presets: names.
        trackers: names of entrants, see ``benchmarks.run.contestants``.
        seeds: of the episodes.
        renderer: which one draws.
        controllers: who steers the camera, ``SET_PATH`` for nobody; None = as each preset says, and where
            that says that the tracker steers, by the suite's controller; everyone where they are contestants.
        link: how commands reach the carrier where controllers are contestants; elsewhere it gets them as they are.
        workers: processes; 0 = this very process (then a tracker that ends its process ends everything).
        repeats: runs an episode of a tracker whose random numbers no seed reaches.
        limit_s: the longest a tracker may take over a frame.
        settings: tracker → values to set it to, other than those it was tuned to.
        modules: users' own modules to import first.
        backend: joblib's backend; ``loky`` are processes of this machine.
    """

    suite: str
    scenario: str
    presets: tuple[str, ...]
    trackers: tuple[str, ...]
    seeds: range
    renderer: RendererName = "raster"
    controllers: tuple[str, ...] | None = None
    link: str = "prompt"
    workers: int = 1
    repeats: int = 3
    limit_s: float = 60.0
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    modules: tuple[str, ...] = ()
    backend: str = "loky"


@dataclass
class Outcome:
    """What came of a run.

    Attributes:
        summary: the list of ``summary.json``.
        failures: trackers that failed.
        silent: tracker → frames on which it said nothing.
        episodes: number of (tracker, episode) pairs that were run, and ``resumed`` that were there already.
        moved: lines that say which rows were moved out of the way, and where to.
    """

    summary: list[dict[str, Any]] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    silent: dict[str, int] = field(default_factory=dict)
    episodes: int = 0
    resumed: int = 0
    moved: list[str] = field(default_factory=list)

    def followed_by(self, later: Outcome) -> Outcome:
        """Return this and what came of a later run into the same folder."""
        silent = {
            name: self.silent.get(name, 0) + later.silent.get(name, 0) for name in {**self.silent, **later.silent}
        }
        failures, moved = [*self.failures, *later.failures], [*self.moved, *later.moved]
        episodes, resumed = self.episodes + later.episodes, self.resumed + later.resumed
        return Outcome(later.summary, failures, silent, episodes, resumed, moved)


Progress = Callable[[int, int], None]
"""Is called with the number of (tracker, episode) pairs that are done, and of all."""


def run(experiment: Experiment, out: Path, progress: Progress | None = None) -> Outcome:
    """Run what is not there yet, write rows as they come, then the summary.

    The same call after a stop goes on where it stopped. Rows that other code or parameters made are moved to a file
    beside and made again. Rows do not depend on the number of workers, but for times.

    Raises:
        ValueError: for unknown names, or a folder that holds other seeds' rows or cannot be written.
    """
    load_modules(experiment.modules)
    check_names(experiment)
    make_folder(out)
    versions = _versions(experiment)
    have, moved = current_blocks(out, experiment.seeds, partial(_made_now, experiment, versions))
    jobs = (_what_is_left(job, have) for job in _jobs(experiment, versions, out / _NOTES))
    outcome = Outcome(resumed=len(have), moved=moved)
    total = len(experiment.seeds) * sum(map(len, versions.values()))
    report = progress or (lambda done, of: None)
    report(len(have), total)
    for result in results((job for job in jobs if job.trackers), experiment.workers, experiment.backend):
        for block in result.blocks:
            append_block(out, block)
        outcome.episodes += len(result.blocks)
        outcome.failures += result.failures
        for name, frames in result.silent.items():
            outcome.silent[name] = outcome.silent.get(name, 0) + frames
        report(len(have) + outcome.episodes, total)
    with contextlib.suppress(OSError):
        (out / _NOTES).rmdir()
    # Workers finish in any order; the file does not show it.
    outcome.moved += filter(None, [tidy(out)])
    outcome.summary = write_summary(out)
    return outcome


def make_folder(out: Path) -> None:
    """Make a folder for results. Raises ValueError if it cannot be made or written."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise ValueError(f"out: expected a folder that can be written, got {str(out)!r}: {error.strerror}") from None


_Versions = dict[tuple[str, str | None], dict[str, dict[str, str]]]
"""Preset and controller (None on a set path) → tracker → what its rows say of their making."""


def _versions(experiment: Experiment) -> _Versions:
    carrier = catalog.scenario(experiment.scenario).carrier.name
    versions: _Versions = {}
    for preset in experiment.presets:
        for controller in _controllers(experiment, preset):
            steered_by = None if controller is None else catalogue.controller_entry(controller, carrier)
            where = (experiment.suite, experiment.scenario, preset)
            versions[preset, controller] = {
                name: versions_of(*where, entrant(name, experiment.settings.get(name)), steered_by)
                for name in experiment.trackers
            }
    return versions


def _jobs(experiment: Experiment, versions: _Versions, notes: Path) -> Iterator[Job]:
    """Yield one job for each episode on a set path, and for each tracker in each episode in closed loop."""
    for (preset, controller), made in versions.items():
        groups = [experiment.trackers] if controller is None else [(name,) for name in experiment.trackers]
        for seed in experiment.seeds:
            for trackers in groups:
                yield Job(
                    suite=experiment.suite,
                    scenario=catalog.scenario(experiment.scenario).id,
                    preset=preset,
                    renderer=experiment.renderer,
                    seed=seed,
                    controller=controller,
                    trackers=trackers,
                    link=link_in(experiment.suite, experiment.link),
                    modules=experiment.modules,
                    repeats=experiment.repeats,
                    limit_s=experiment.limit_s,
                    settings={name: (name, values) for name, values in experiment.settings.items()},
                    notes=notes,
                    versions=made,
                )


def _controllers(experiment: Experiment, preset: str) -> list[str | None]:
    if experiment.controllers is None and suite(experiment.suite).judges_controllers:
        return list(controllers_of(experiment.suite, experiment.scenario))
    if experiment.controllers is None:
        steered = catalog.scenario(experiment.scenario).presets[preset].closed_loop
        return [suite(experiment.suite).controller if steered else None]
    return [None if name == SET_PATH else name for name in experiment.controllers]


def check_renderer(name: str) -> RendererName:
    """Return a renderer's name. Raises ValueError if it is none."""
    for known in get_args(RendererName):
        if name == known:
            return known
    raise ValueError(f"renderer: expected one of {', '.join(get_args(RendererName))}; got {name!r}")


def check_names(experiment: Experiment) -> None:
    """Raise ValueError, naming the parameter, what was expected and what came, for what does not exist."""
    scenario = catalog.scenario(experiment.scenario)
    if suite(experiment.suite).judges_controllers and not scenario.carrier.axes:
        raise ValueError(f"scenario: expected one with a camera that can be steered, got {scenario.id!r}")
    presets = scenario.presets
    known = {
        "presets": (experiment.presets, tuple(presets)),
        "controllers": (_registered(experiment), controllers_of(experiment.suite, experiment.scenario)),
        "link": ((experiment.link,), tuple(LINKS)),
    }
    for parameter, (given, expected) in known.items():
        for name in given:
            if name not in expected:
                raise ValueError(f"{parameter}: expected one of {', '.join(expected)}; got {name!r}")
    _check_trackers(experiment)
    check_renderer(experiment.renderer)
    if len(experiment.seeds) == 0 or experiment.seeds.start < 0:
        came = f"{experiment.seeds.start}:{experiment.seeds.stop}"
        raise ValueError(f"seeds: expected A:B with 0 <= A < B, got {came}")
    if experiment.workers < 0:
        raise ValueError(f"workers: expected a whole number >= 0, got {experiment.workers}")
    if experiment.limit_s <= 0:
        raise ValueError(f"limit_s: expected a number of seconds > 0, got {experiment.limit_s:g}")


def controllers_of(suite_name: str, scenario: str) -> tuple[str, ...]:
    """Return the names of those who may steer in a suite, ``SET_PATH`` for nobody where that is a choice."""
    judged = suite(suite_name)
    steering = tuple(catalogue.controllers(catalog.scenario(scenario).carrier.name))
    if judged.judges_controllers:
        return steering
    return (SET_PATH,) if judged.controller is None else (SET_PATH, *steering)


def _registered(experiment: Experiment) -> list[str]:
    """Return the controllers that are not policies in files. Raises ValueError for a file that holds no fit policy."""
    carrier = catalog.scenario(experiment.scenario).carrier.name
    registered = []
    for name in experiment.controllers or ():
        if name.startswith(catalogue.POLICY) and suite(experiment.suite).controller is not None:
            catalogue.controller_entry(name, carrier)
        else:
            registered.append(name)
    return registered


def _check_trackers(experiment: Experiment) -> None:
    judged = suite(experiment.suite)
    everyone, expected = entrants(), entrants(judged.tracked_by(judged.scene(experiment.scenario)))
    for name in experiment.trackers:
        if name not in expected:
            whose = f", which is of suite {', '.join(everyone[name].suites)}" if name in everyone else ""
            raise ValueError(f"trackers: expected one of {', '.join(expected)}; got {name!r}{whose}")
        known = registry.entries().get(name)
        if judged.follows_many and known is not None and not known.follows_many:
            raise ValueError(f"trackers: expected ones of many targets, with a method start; got {name!r}")


def _key(job: Job, tracker: str) -> BlockKey:
    steering = job.controller or ""
    return BlockKey(job.suite, job.scenario, job.preset, job.renderer, steering, tracker, job.seed, job.link or "")


def _made_now(experiment: Experiment, versions: _Versions, key: BlockKey) -> dict[str, str] | None:
    scenario, link = catalog.scenario(experiment.scenario).id, link_in(experiment.suite, experiment.link) or ""
    if (key.suite, key.scenario, key.renderer, key.link) != (experiment.suite, scenario, experiment.renderer, link):
        return None
    return versions.get((key.preset, key.controller or None), {}).get(key.tracker)


def current_blocks(
    out: Path, seeds: range, made_now: Callable[[BlockKey], dict[str, str] | None]
) -> tuple[set[BlockKey], list[str]]:
    """Return which blocks of an experiment a folder holds already, made by the same code, and what is said of other
    makings, which are moved out of the way.

    Args:
        made_now: returns ``versions`` of a block that is the experiment's as they are now, None of other blocks.

    Raises:
        ValueError: for a folder that holds other seeds' rows.
    """
    if not (out / FILE_NAME).is_file():
        return set(), []
    blocks = read_blocks(out)
    # A person may have played other episodes than these.
    strangers = sorted(key.seed for key in blocks if key.controller != HUMAN and key.seed not in seeds)
    if strangers:
        wanted = f"{seeds.start}:{seeds.stop}"
        raise ValueError(
            f"out: expected a folder with no seeds but {wanted}, got {str(out)!r}, which holds seed {strangers[0]}"
        )
    mine = {key: made for key in blocks if (made := made_now(key)) is not None}
    outdated = {key for key, made in mine.items() if blocks[key][0].get("versions") != made}
    return mine.keys() - outdated, list(filter(None, [tidy(out, outdated)]))


def _what_is_left(job: Job, have: set[BlockKey]) -> Job:
    return replace(job, trackers=tuple(name for name in job.trackers if _key(job, name) not in have))
