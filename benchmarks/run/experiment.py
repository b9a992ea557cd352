"""Runs a suite: every contestant in every episode, on all cores, resumable, safe from failing trackers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, cast, get_args

from benchmarks.contract.rows import ESTIMATES, FILE_NAME, REAL, BlockKey, MadeNow, append_block, tidy, up_to_date
from benchmarks.contract.suite import suite, suites
from benchmarks.run.alone import alone_in
from benchmarks.run.contestants import entrant, entrants, entrants_of
from benchmarks.run.editions import Editions, editions_of, editions_on_recordings
from benchmarks.run.jobs import Job
from benchmarks.run.keeping import Keeper
from benchmarks.run.known_failures import earlier, read_failures, write_failures
from benchmarks.run.outcome import Outcome
from benchmarks.run.own_modules import load_modules
from benchmarks.run.processes import results
from benchmarks.run.real import RealEpisode, trackers_on_pictures, up_to_date_on
from benchmarks.run.steering import default_controllers, link_in
from benchmarks.statistics.summary import write_summary
from scenarios import catalog
from scenarios.command_link import LINKS
from scenarios.scenario import Episode, RendererName
from sim.checks import check, check_choice, suggestion
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
        controllers: names of those that steer the camera, ``SET_PATH`` for none; None = ``default_controllers`` where
            they are contestants, else the suite's controller in presets in closed loop.
        link: how commands reach the carrier where controllers are contestants; elsewhere commands arrive unchanged.
        workers: processes; 0 = this process (then a tracker that ends its process ends the run).
        repeats: runs per episode of a tracker whose random numbers no seed reaches.
        limit_s: of CPU time of a tracker for one frame, see ``time_limit.at_most``.
        settings: name in ``trackers`` → the entrant that runs under it, and its parameter values.
        changes: name in ``presets`` → the preset that it is a change of, and its changed fields.
        modules: users' own modules to import first.
        backend: joblib's backend; ``loky`` are processes of this machine.
        stored: returns the stored episode of a seed; None = episodes are rendered.
        keeper: keeps all answers beside the rows; None = they are not kept.
        real: what takes the place of simulated episodes, of which scenario, presets, seeds and renderer are then those
            of ``rows``; () = nothing.
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
    settings: dict[str, tuple[str, dict[str, Any]]] = field(default_factory=dict)
    changes: dict[str, tuple[str, dict[str, Any]]] = field(default_factory=dict)
    modules: tuple[str, ...] = ()
    backend: str = "loky"
    stored: Callable[[int], Episode] | None = None
    keeper: Keeper | None = None
    real: tuple[RealEpisode, ...] = ()


Progress = Callable[[int, int], None]
"""Called with the number of (tracker, episode) pairs done, and of all."""


def run(experiment: Experiment, out: Path, progress: Progress | None = None) -> Outcome:
    """Run the missing episodes, write rows as they arrive, then the summary.

    The same call after a stop continues. Rows of other editions or parameters are moved to another file and made
    again, and so are rows without the estimates that are asked for. Except for times, ``workers`` changes no row.

    Raises:
        ValueError: for unknown names, or a folder that holds rows of other seeds, cannot be written, or is written by
            another run; and if there is no row at the end.
    """
    load_modules(experiment.modules)
    check_names(experiment)
    make_folder(out)
    with alone_in(out):
        return _run(experiment, out, progress)


def _run(experiment: Experiment, out: Path, progress: Progress | None) -> Outcome:
    made_now = made_now_of(experiment)
    # Workers of an earlier run may have been started in another folder.
    whole = out.resolve()
    if experiment.real:
        on_real = _editions_on_real(experiment)
        have, moved = up_to_date_on(experiment.real, experiment.suite, on_real, out)
        every_job, total = _jobs_on_real(experiment, on_real, whole), len(experiment.real) * len(on_real)
    else:
        editions = _editions(experiment)
        have, moved = up_to_date(out, experiment.seeds, made_now)
        every_job, total = _jobs(experiment, editions, whole), len(experiment.seeds) * sum(map(len, editions.values()))
    if experiment.keeper is not None:
        have = {key for key in have if experiment.keeper.is_kept(out / ESTIMATES, key, made_now(key))}
    jobs = (_remaining(job, have) for job in every_job)
    outcome = Outcome(resumed=len(have), moved=moved)
    failures = {key: each for key, each in read_failures(out).items() if key in have or made_now(key) is None}
    write_failures(out, failures)
    outcome.failures += (earlier(each) for key in sorted(have & failures.keys()) for each in failures[key])
    # The command that repeats the run names it.
    limited = {} if experiment.limit_s == Experiment.limit_s else {"limit_s": experiment.limit_s}
    report = progress or (lambda done, of: None)
    report(len(have), total)
    for result in results((job for job in jobs if job.trackers), experiment.workers, experiment.backend):
        # Before the rows: failures without rows are dropped, rows without their failures would be taken for good ones.
        if result.failures:
            for failure in result.failures:
                name = result.job.trackers[0] if result.job.controller else failure.tracker
                failures.setdefault(_key(result.job, name), []).append(failure)
            write_failures(out, failures)
        for block in result.blocks:
            append_block(out, [row | limited for row in block])
        outcome.episodes += len(result.job.trackers)
        outcome.failures += result.failures
        outcome.silent += result.silent
        outcome.oddities += result.oddities
        outcome.unusable += [result.unusable] if result.unusable not in ("", *outcome.unusable) else []
        report(len(have) + outcome.episodes, total)
    with contextlib.suppress(OSError):
        (out / _NOTES).rmdir()
    if not (out / FILE_NAME).is_file():
        raise ValueError(_why_no_row(experiment, outcome))
    # Workers finish in any order; the file has a canonical one.
    outcome.moved += filter(None, [tidy(out)])
    outcome.summary = write_summary(out)
    return outcome


def _why_no_row(experiment: Experiment, outcome: Outcome) -> str:
    if outcome.failures:
        return f"trackers: expected some that can begin, got {next(outcome.failures_in_words())}"
    return next(
        iter(outcome.unusable), f"trackers: expected some with a gap method, got {', '.join(experiment.trackers)}"
    )


def made_now_of(experiment: Experiment) -> MadeNow:
    """Return what tells the current ``editions`` of the blocks of an experiment."""
    if experiment.real:
        known = {(each.preset, each.seed): each for each in experiment.real}
        return partial(_made_now_on_real, experiment, known, _editions_on_real(experiment))
    return partial(_made_now, experiment, _editions(experiment))


def jobs_of(experiment: Experiment) -> list[Job]:
    """Return the jobs of an experiment, for a trial: their rows have no editions and leave no notes."""
    load_modules(experiment.modules)
    check_names(experiment)
    return [replace(job, notes=None, editions={}) for job in _jobs(experiment, _editions(experiment), Path())]


def make_folder(out: Path, parameter: str = "out") -> None:
    """Make a folder for results. Raises ValueError, which names the parameter, if it cannot be made or written."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as error:
        expected = f"{parameter}: expected a folder that can be written"
        raise ValueError(f"{expected}, got {str(out)!r}: {error.strerror}") from None


def check_file(file: Path, parameter: str) -> None:
    """Make the folder of a file. Raises ValueError, which names the parameter, if it fails or the file is a folder."""
    make_folder(file.parent, parameter)
    check(parameter, not file.is_dir(), "a file", f"the folder {str(file)!r}")


_Editions = dict[tuple[str, str | None], dict[str, Editions]]
"""Preset and controller (None on a set path) → tracker → ``editions`` of its rows."""


def _editions(experiment: Experiment) -> _Editions:
    carrier = catalog.scenario(experiment.scenario).carrier.name
    contestants = {name: entrant(*experiment.settings.get(name, (name,))) for name in experiment.trackers}
    editions: _Editions = {}
    for preset in experiment.presets:
        for controller in _controllers(experiment, preset):
            steered_by = None if controller is None else catalogue.controller_entry(controller, carrier)
            of, changed = experiment.changes.get(preset, (preset, {}))
            where = (experiment.suite, experiment.scenario, of)
            editions[preset, controller] = {
                name: editions_of(*where, each, steered_by, changed, experiment.renderer)
                for name, each in contestants.items()
            }
    return editions


def _jobs(experiment: Experiment, editions: _Editions, out: Path) -> Iterator[Job]:
    """Yield one job for each episode on a set path, and for each tracker in each episode in closed loop.

    Those of a seed come together: a worker keeps what it has drawn of the latest world.
    """
    for seed in experiment.seeds:
        for (preset, controller), made in editions.items():
            groups = [experiment.trackers] if controller is None else [(name,) for name in experiment.trackers]
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
                    settings=experiment.settings,
                    changes=experiment.changes.get(preset),
                    notes=out / _NOTES,
                    editions=made,
                    stored=experiment.stored,
                    keeper=experiment.keeper,
                    estimates=out / ESTIMATES,
                )


def _editions_on_real(experiment: Experiment) -> dict[str, Editions]:
    """Return ``editions`` of rows about what is real by tracker, but for ``scene``."""
    return {name: editions_on_recordings(experiment.suite, entrant(name)) for name in experiment.trackers}


def _jobs_on_real(experiment: Experiment, editions: dict[str, Editions], out: Path) -> Iterator[Job]:
    """Yield one job for each sequence of pictures, and for each tracker on each recording of tracks."""
    for episode in experiment.real:
        scene = {"scene": episode.scene}
        groups = [experiment.trackers] if episode.sequence else [(name,) for name in experiment.trackers]
        for trackers in groups:
            yield Job(
                suite=experiment.suite,
                scenario=REAL,
                preset=episode.preset,
                renderer=REAL,
                seed=episode.seed,
                controller=None,
                trackers=trackers,
                modules=experiment.modules,
                repeats=experiment.repeats,
                limit_s=experiment.limit_s,
                notes=out / _NOTES,
                editions={name: each | scene for name, each in editions.items()},
                keeper=experiment.keeper,
                estimates=out / ESTIMATES,
                real=episode,
            )


def _controllers(experiment: Experiment, preset: str) -> list[str | None]:
    if experiment.controllers is None and suite(experiment.suite).judges_controllers:
        return list(default_controllers(experiment.scenario))
    if experiment.controllers is None:
        of, _ = experiment.changes.get(preset, (preset, {}))
        steered = catalog.scenario(experiment.scenario).presets[of].closed_loop
        return [suite(experiment.suite).controller if steered else None]
    return [None if name == SET_PATH else name for name in experiment.controllers]


def check_renderer(name: str) -> RendererName:
    """Return a renderer's name. Raises ValueError for an unknown one."""
    check_choice("renderer", name, get_args(RendererName))
    return cast(RendererName, name)


def check_names(experiment: Experiment) -> None:
    """Raise ValueError for unknown names and values out of range."""
    if experiment.real:
        _check_trackers_on_real(experiment)
    else:
        _check_simulated(experiment)
    check_limits(experiment)


def check_limits(experiment: Experiment) -> None:
    """Raise ValueError for a number of workers or a time limit out of range."""
    check("workers", experiment.workers >= 0, "a whole number >= 0", experiment.workers)
    good = isinstance(experiment.limit_s, int | float) and experiment.limit_s > 0
    check("limit_s", good, "a number of seconds > 0", repr(experiment.limit_s))


def _check_simulated(experiment: Experiment) -> None:
    scenario = catalog.scenario(experiment.scenario)
    if suite(experiment.suite).judges_controllers:
        check("scenario", bool(scenario.carrier.axes), "one with a camera that can be steered", repr(scenario.id))
    presets = [experiment.changes.get(name, (name, {}))[0] for name in experiment.presets]
    known = {
        "preset": (presets, tuple(scenario.presets)),
        "controllers": (_registered(experiment), controllers_of(experiment.suite, experiment.scenario)),
        "link": ((experiment.link,), tuple(LINKS)),
    }
    for parameter, (given, expected) in known.items():
        for name in given:
            why = catalogue.steers_instead(name) if parameter == "controllers" else ""
            check_choice(parameter, name, expected, why=why)
    _check_trackers(experiment)
    check_renderer(experiment.renderer)
    first, end = experiment.seeds.start, experiment.seeds.stop
    check("seeds", 0 <= first < end, "A:B with 0 <= A < B", f"{first}:{end}")


def controllers_of(suite_name: str, scenario: str) -> tuple[str, ...]:
    """Return the names of the controllers of a suite, with ``SET_PATH`` where a set path is a choice."""
    judged = suite(suite_name)
    steering = tuple(catalogue.controllers(catalog.scenario(scenario).carrier.name))
    if judged.judges_controllers:
        return steering
    return (SET_PATH,) if judged.controller is None else (SET_PATH, *steering)


def _registered(experiment: Experiment) -> list[str]:
    """Return the controllers that are not policies in files. Raises ValueError for a file without a usable policy."""
    registered = []
    for name in experiment.controllers or ():
        if name.startswith(catalogue.POLICY) and suite(experiment.suite).controller is not None:
            catalogue.controller_entry(name, catalog.scenario(experiment.scenario).carrier.name)
        else:
            registered.append(name)
    return registered


def _check_trackers(experiment: Experiment) -> None:
    judged = suite(experiment.suite)
    known, expected = entrants(), entrants_of(judged, judged.scene(experiment.scenario))
    for name in (experiment.settings.get(label, (label,))[0] for label in experiment.trackers):
        whose = f", which is of suite {_suites_in_words(known[name].suites)}" if name in known else ""
        if not (whose or experiment.modules):
            whose = suggestion(name, expected) + f"{registry.OWN_NEEDS_MODULE} (--modules; in Python modules=)"
        check_choice("trackers", name, expected, why=whose)
        entry = registry.entries().get(name)
        many = not judged.follows_many or entry is None or entry.follows_many
        check("trackers", many, "ones of many targets, with a method start", repr(name))


def _check_trackers_on_real(experiment: Experiment) -> None:
    on_pictures = any(episode.sequence for episode in experiment.real)
    expected = trackers_on_pictures(suite(experiment.suite)) if on_pictures else registry.entries()
    for name in experiment.trackers:
        if on_pictures:
            wanted = f"some of {', '.join(expected)}, which need pictures alone"
            check("trackers", name in expected, wanted, repr(name))
        else:
            registry.entry(name)


def _suites_in_words(wanted: Sequence[str]) -> str:
    """Return the names of a tracker's suites, which a user may have misspelt."""
    return ", ".join(name if name in suites() else f"{name} (there is no such suite)" for name in wanted)


def _key(job: Job, tracker: str) -> BlockKey:
    steering = job.controller or ""
    return BlockKey(job.suite, job.scenario, job.preset, job.renderer, steering, tracker, job.seed, job.link or "")


def _made_now(experiment: Experiment, editions: _Editions, key: BlockKey) -> Editions | None:
    scenario, link = catalog.scenario(experiment.scenario).id, link_in(experiment.suite, experiment.link) or ""
    if (key.suite, key.scenario, key.renderer, key.link) != (experiment.suite, scenario, experiment.renderer, link):
        return None
    return editions.get((key.preset, key.controller or None), {}).get(key.tracker)


def _made_now_on_real(
    experiment: Experiment,
    known: dict[tuple[str, int], RealEpisode],
    editions: dict[str, Editions],
    key: BlockKey,
) -> Editions | None:
    episode, made = known.get((key.preset, key.seed)), editions.get(key.tracker)
    if (key.suite, key.scenario) != (experiment.suite, REAL) or episode is None or made is None:
        return None
    return made | {"scene": episode.scene}


def _remaining(job: Job, have: set[BlockKey]) -> Job:
    return replace(job, trackers=tuple(name for name in job.trackers if _key(job, name) not in have))
