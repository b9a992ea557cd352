"""Runs a suite from Python, as ``frameout bench`` does: the command calls this function.

In a notebook or a script::

    from benchmarks import bench

    results = bench("frame-out", preset="quick", seeds=range(2), trackers=["mosaic_graph_pf", "hold"])
    results.rows()  # a DataFrame, one line for each number
    results.plot("recovery_rate")  # a matplotlib Figure
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.contract import suite as registry
from benchmarks.contract.judging import check_no_layout
from benchmarks.contract.rows import REAL
from benchmarks.contract.suite import DEFAULT, Suite
from benchmarks.contract.text import counted
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.contract.varied import base_of
from benchmarks.run.experiment import Experiment, ShowProgress, run
from benchmarks.run.outcome import Outcome, TrackerWarning
from benchmarks.run.own_modules import load_modules
from benchmarks.run.packages import needs_data
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.selection import (
    Registered,
    choices,
    experiment_on,
    registered,
    trackers_of,
    varied_names,
    with_value,
)
from benchmarks.run.workers import cores
from benchmarks.show.results import Results
from sim.checks import check
from trackers.registry import entry

if TYPE_CHECKING:
    from benchmarks.data.sets.request import Request

_NEED_TRUTH = ("blind", "oracle")
"""Roles of trackers that are given the true state in metres."""
Names = dict[str, tuple[str, ...]]
"""What users name: scenarios, presets, trackers, controllers, see ``choices``."""


def bench(
    suite: str | Suite = DEFAULT,
    *,
    seeds: range | None = None,
    scenario: str | Sequence[str] | None = None,
    preset: str | Sequence[str] | None = None,
    settings: str | Sequence[str] = (),
    trackers: str | Sequence[str] | None = None,
    process: str | Sequence[str] | Mapping[str, str] = (),
    controllers: str | Sequence[str] | None = None,
    link: str = "prompt",
    renderer: str = "raster",
    quick: bool = False,
    out: Path | str | None = None,
    workers: int | None = None,
    limit_s: float = 60.0,
    real_time: float | None = None,
    repeats: int | None = None,
    vary: str | Sequence[str] = (),
    modules: str | Sequence[str] = (),
    data: str | None = None,
    keep_estimates: bool = False,
    real: Path | str | Sequence[Path | str] = (),
    layout: str = "",
    target: int | str | None = None,
    rate_hz: float | None = None,
    progress: ShowProgress = lambda title: nullcontext(),
) -> Results:
    """Run trackers in the episodes of a suite and return the results; what exists already is not run again.

    Args:
        suite: name, see ``frameout list``.
        seeds: of the episodes, ``range(A, B)``; 0 to 9,999 are for development, 10,000 to 19,999 are the test split.
            They must be given, but for ``real``, which has none: all of it runs.
        scenario, preset, trackers, controllers: a name or several; None = as ``frameout bench --help`` says.
        settings: other values of fields of the presets, ``FIELD=VALUE``, see ``scenarios.field_values``.
        process: trackers in processes of their own: name → command, or arguments as ``frameout bench --process`` takes;
            they run beside the others, or alone if ``trackers`` names them.
        link: how commands reach the carrier where controllers are trackers: prompt, delayed, noisy or late.
        renderer: raster or pybullet.
        quick: small presets, no variants, one repeat.
        out: folder of the results; None = ``results/SUITE``, ``results/quick``, or ``results/SUITE-real``; in real time
            each with the rate at its end.
        workers: processes; None = one per core, 0 = this process.
        limit_s: most CPU time in seconds for one frame of a tracker; it may wait, e.g. sleep, ten times as long.
        real_time: pictures a second, which do not wait for a tracker, see ``benchmarks.run.real_time``.
        repeats: runs an episode of each tracker, with random numbers of their own; None = 3, with ``quick`` 1, of one
            that no seed makes reproducible, else 1.
        vary: trackers with other values of a parameter, ``NAME.PARAMETER=V1,V2``, which are called
            ``NAME[PARAMETER=V1]``; without ``trackers`` they run alone.
        modules: modules of yours to import first, also in the workers; they register trackers, metrics and so on.
        data: folder or URL of a data set with the episodes, whose scenario, preset and renderer are given.
        keep_estimates: whether all answers are kept as tables, see ``benchmarks.data.estimates.block_file``.
        real: files of tracks or folders of pictures with boxes in place of episodes, see ``frameout bench --help``.
        layout, target, rate_hz: of such folders, see ``benchmarks.data.layouts.collection.read_collections``.
        progress: shows progress, see ``ShowProgress``.

    Raises:
        ValueError: for unknown names and values out of range, before any run; names the argument.
        ChildProcessError: if a worker process ends outside of any tracker; the same call continues.

    A tracker that fails, or gave no answer or odd ones on frames of this run, is scored as such, and a
    ``TrackerWarning`` says so; ``outcome.failures`` of the results has every failure. Another one names a sequence or
    recording that cannot be used, of which there are no rows; the others are scored.
    """
    paths = paths_of(real)
    given_seeds = isinstance(seeds, range) or (bool(paths) and seeds is None)
    check("seeds", given_seeds, "range(A, B)", repr(seeds))
    wanted, own_modules = suite_after(modules, suite)
    if isinstance(process, Mapping):
        process = [f"{name}={command}" for name, command in process.items()]
    added = process_trackers((process,) if isinstance(process, str) else process, limit_s)
    other_values = varied_names((vary,) if isinstance(vary, str) else vary)
    names = {
        "scenarios": several("scenario", scenario),
        "presets": several("preset", preset),
        "settings": (settings,) if isinstance(settings, str) else tuple(settings),
        "trackers": with_added((*several("trackers", trackers), *other_values), added),
        "controllers": several("controllers", controllers),
    }
    how: dict[str, Any] = {
        "workers": cores(workers),
        "repeats": 1 if quick and repeats is None else repeats,
        "limit_s": limit_s,
        "real_time_hz": real_time,
        "modules": own_modules,
    }
    if keep_estimates:
        needs_data()
        from benchmarks.data.estimates.keeping import Estimates

        how["keeper"] = Estimates()
    outcome = Outcome()
    if paths:
        from benchmarks.data.real import real_episodes  # It imports the readers of all layouts.

        refuse("none with --real, which runs no episodes", seeds=seeds, data=data, **_episodes_of(names))
        refuse("raster with --real, which draws nothing", renderer=renderer != "raster" and renderer)
        _check_steering(wanted, link, None)
        kept = keep_estimates and wanted.on_sequences is None
        seen = real_time is None or wanted.on_sequences is not None
        check("real_time", seen, "none with tracks, on which no picture is seen", real_time)
        check("keep_estimates", not kept, "none with tracks, on which no frame is judged", keep_estimates)
        Experiment(wanted, [], {}, **how)  # A number out of range is refused before anything is read.
        episodes, outcome.unusable = real_episodes(wanted, paths, layout, target, rate_hz)
        chosen = _trackers_on_real(wanted, names["trackers"], added, quick=quick)
        experiments = [Experiment(wanted, episodes, chosen, **how)]
        name = f"{wanted.name}-real"
    else:
        check_no_layout(layout, target, rate_hz)
        assert seeds is not None
        _check_steering(wanted, link, data)
        experiments = _experiments(wanted, names, added, seeds, link, data, renderer, quick=quick, how=how)
        name = "quick" if quick else wanted.name
    folder = Path(out or Path("results") / (name if real_time is None else f"{name}-{real_time:g}hz"))
    silence = wanted.silence_in(REAL if paths else "")
    return run_all(experiments, folder, outcome, silence, progress)


def paths_of(given: Path | str | Sequence[Path | str]) -> list[Path]:
    """Return one path or several."""
    return [Path(each) for each in ((given,) if isinstance(given, Path | str) else given)]


def suite_after(modules: str | Sequence[str], suite: str | Suite) -> tuple[Suite, tuple[str, ...]]:
    """Import modules, which may register a suite or add to one; return the suite, and their names.

    Raises:
        ValueError: for a module that cannot be imported, an unknown name, and what is no suite.
    """
    own_modules = (modules,) if isinstance(modules, str) else tuple(modules)
    load_modules(own_modules)
    check("suite", isinstance(suite, str | Suite), "a name or a Suite; each suite has results of its own", repr(suite))
    # Summaries look suites up by the name in rows: one that is not registered is refused.
    known = registry.suite(suite if isinstance(suite, str) else suite.name)
    return known if isinstance(suite, str) else suite, own_modules


def run_all(
    experiments: Sequence[Experiment], folder: Path, outcome: Outcome, silence: str, progress: ShowProgress
) -> Results:
    """Run experiments one after the other and return the results of their folder.

    Args:
        outcome: of reading what they run on.
        silence: see ``Suite.silence_in``.
    """
    for experiment in experiments:
        title = f"{experiment.suite.name}, {counted(len(experiment.trackers), 'tracker')}"
        with progress(title) as report:
            outcome = outcome.followed_by(run(experiment, folder, report or (lambda done, of: None)))
    for line in (*outcome.unusable, *outcome.failures_in_words(), *outcome.oddities_in_words(silence)):
        warnings.warn(line, TrackerWarning, stacklevel=3)
    return Results(folder, outcome)


def with_added(names: tuple[str, ...], added: Mapping[str, TrackerSpec]) -> tuple[str, ...]:
    """Return the names of trackers that run: those given, and all that are added unless some of these are given."""
    return names if not names or not added.keys().isdisjoint(names) else (*names, *added)


def check_suites(
    suites: Iterable[Suite],
    names: Names,
    added: Mapping[str, TrackerSpec],
    *,
    link: str,
    data: str | None,
    quick: bool,
    modules: Sequence[str],
) -> None:
    """Raise ValueError for what one of several suites would refuse, before the first one runs for hours.

    Args:
        suites: those that are to run one after the other.
        names: in each; stored scenarios and presets are checked where they are read.
        added: trackers of processes. link, data, quick, modules: see ``bench``.
    """
    for wanted in suites:
        _check_steering(wanted, link, data)
        if data is None:
            how = {"modules": tuple(modules)}
            _experiments(wanted, names, added, range(1), link, None, "raster", quick=quick, how=how)


def refuse(expected: str, **given: object) -> None:
    """Raise ValueError, saying what is ``expected``, for the first argument that is given."""
    for name, value in given.items():
        check(name, value in (None, (), False), expected, repr(value))


def _episodes_of(names: Names) -> Names:
    """Return the names that choose episodes, by argument."""
    given = {"scenario": names["scenarios"], "preset": names["presets"], "set": names["settings"]}
    return given | {"controllers": names["controllers"]}


def _check_steering(wanted: Suite, link: str, data: str | None) -> None:
    linked = link == "prompt" or wanted.judges_controllers
    check("link", linked, f"prompt, since suite {wanted.name} knows no other", repr(link))
    stored = data is not None and wanted.judges_controllers
    check("data", not stored, f"none with suite {wanted.name}, as stored pictures cannot be steered", data)


def _experiments(
    wanted: Suite,
    names: Names,
    added: Mapping[str, TrackerSpec],
    seeds: range,
    link: str,
    data: str | None,
    renderer: str,
    *,
    quick: bool,
    how: dict[str, Any],
) -> list[Experiment]:
    """Return an experiment for each scenario. Raises ValueError for unknown names."""
    if data is not None:
        stored = _stored(data, seeds, renderer, names)
        names = {"scenarios": (stored.scenario,), "presets": (stored.preset,), "trackers": names["trackers"]}
        renderer = stored.renderer
    elif quick and not names["presets"]:
        names = names | {"presets": (wanted.quick_preset,)}
    experiments = []
    chosen = choices(wanted, **names, added=added, variants=not quick, own_modules=bool(how["modules"]))
    for scenario, presets, trackers, controllers in chosen:
        by: Any = {"controllers": controllers or None, "link": link, "renderer": renderer}
        made = experiment_on(wanted, scenario, presets, trackers, seeds, **by, **how)
        _check_usable(made.trackers.values())
        if data is not None:
            # Here, since it imports the packages of the extra.
            from benchmarks.data.sets.benchmark import stored_specs

            made = replace(made, episodes=stored_specs(data, made.episodes))
        experiments.append(made)
    return experiments


def _trackers_on_real(
    wanted: Suite, names: tuple[str, ...], added: Mapping[str, TrackerSpec], *, quick: bool
) -> dict[str, TrackerSpec]:
    """Return the trackers that run on what is real. Raises ValueError for unknown names."""
    ours: dict[str, TrackerSpec] = {
        name: each for name, each in trackers_of(wanted.name).items() if isinstance(each, Registered)
    }
    ours |= {name: each for name, each in added.items() if wanted.name in each.suites}
    if wanted.on_sequences is not None:
        ours = {name: each for name, each in ours.items() if each.role not in _NEED_TRUTH}
        for name in names:
            check(
                "trackers", base_of(name) in ours, f"some of {', '.join(ours)}, which need pictures alone", repr(name)
            )
    able = (name for name, each in ours.items() if not each.missing() and not (quick and each.role == "variant"))
    chosen: dict[str, TrackerSpec] = {
        name: ours.get(name) or with_value(name) or registered(entry(name)) for name in names or able
    }
    _check_usable(chosen.values())
    return chosen


def stored_seeds(data: str) -> range:
    """Return the seeds of a data set, by its folder or URL."""
    return range(*stored_request(data).seeds)


def stored_request(data: str) -> Request:
    needs_data()
    from benchmarks.data.sets.benchmark import benchmark_of

    return benchmark_of(data)


def _stored(data: str, seeds: range, renderer: str, names: Names) -> Request:
    """Return what a data set is of. Raises ValueError for arguments that contradict it."""
    request = stored_request(data)
    refuse("none with data, which sets it", **_episodes_of(names), renderer=renderer != "raster" and renderer)
    first, end = request.seeds
    within = set(seeds) <= set(range(first, end))
    check("seeds", within, f"some of {first}:{end}, which the data set has", f"{seeds.start}:{seeds.stop}")
    return request


def several(parameter: str, names: str | Sequence[str] | None) -> tuple[str, ...]:
    """Return each name once, none for None. Raises ValueError for an empty list, which would run everything."""
    if names is None:
        return ()
    check(parameter, len(names) > 0, "a name or several, or None for the default", repr(names))
    return (names,) if isinstance(names, str) else tuple(dict.fromkeys(names))


def _check_usable(trackers: Iterable[TrackerSpec]) -> None:
    """Raise ValueError for trackers of a cell or a script, which no worker can import and of whose code no row could
    have a digest; and for those that need what is not installed.
    """
    for each in trackers:
        importable = each.module != "__main__"
        own = f"{each.name!r} of __main__"
        check("trackers", importable, "ones that a module of their own registers (modules=…)", own)
        needs = each.missing()
        check("trackers", not needs, "ones of which all that they need is installed", f"{each.name}: {needs}")
