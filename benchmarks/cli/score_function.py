"""Scores predictions made elsewhere from Python, as ``frameout score`` does: the command calls this function."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.cli.bench_function import paths_of, refuse, run_all, several, stored_request, suite_after
from benchmarks.contract import suite as registry
from benchmarks.contract.judging import check_no_layout
from benchmarks.contract.rows import REAL
from benchmarks.contract.suite import DEFAULT, Suite
from benchmarks.contract.text import printable
from benchmarks.data.predictions.folders import Folder, find_folders, predicted_trackers
from benchmarks.data.predictions.formats import FORMATS, SequenceFile
from benchmarks.data.sequence_names import sequence_name, set_name
from benchmarks.run.episodes import Simulated
from benchmarks.run.experiment import Experiment, ShowProgress
from benchmarks.run.outcome import Outcome
from benchmarks.run.selection import SET_PATH, choices, experiment_on, trackers_of
from benchmarks.run.workers import cores
from benchmarks.show.results import Results
from scenarios import catalog
from scenarios.catalog import unversioned
from sim.checks import check


def score(
    suite: str | Suite = DEFAULT,
    *,
    predictions: Path | str | Sequence[Path | str],
    truth: str = "",
    preset: str | Sequence[str] | None = None,
    seeds: range | None = None,
    real: Path | str | Sequence[Path | str] = (),
    layout: str = "",
    target: int | str | None = None,
    rate_hz: float | None = None,
    format: str = "",
    annotations: Path | str | None = None,
    out: Path | str | None = None,
    workers: int | None = None,
    modules: str | Sequence[str] = (),
    progress: ShowProgress = lambda title: nullcontext(),
) -> Results:
    """Score predictions made elsewhere and return the results; those of unchanged files are not scored again.

    Args:
        suite: name, see ``frameout list``.
        predictions: folders, see ``benchmarks.data.predictions.folders``.
        truth: a scenario, "" = the suite's first one; or the folder or URL of a data set.
        preset: a name or several of the scenario; None = the suite's default.
        seeds: of the episodes, ``range(A, B)``; None = all of a data set, else those that the predictions are of.
        real, layout, target, rate_hz: real sequences in place of episodes, see ``benchmarks.bench``.
        format: of all files, see ``benchmarks.data.predictions.formats``; "" = each is recognised.
        annotations: file that the numbers of pictures in JSON results are of.
        out, workers, modules, progress: see ``benchmarks.bench``.

    Raises:
        ValueError: for what cannot be scored, before anything is; names the argument, or file and line.

    A sequence without predictions is scored as silence, and a ``TrackerWarning`` names it.
    """
    wanted, own_modules = suite_after(modules, suite)
    paths, sequences = paths_of(predictions), paths_of(real)
    _check_judged(wanted, pictures=bool(sequences))
    check("predictions", bool(paths), "a folder or several", "none")
    check("seeds", seeds is None or isinstance(seeds, range), "range(A, B), or None", repr(seeds))
    check("format", format in ("", *FORMATS), f"one of {', '.join(FORMATS)}", repr(format))
    numbered_in = None if annotations is None else Path(annotations)
    recorded = ("--predictions", *map(printable, paths), *(("--format", format) if format else ()))
    recorded += () if numbered_in is None else ("--annotations", printable(numbered_in))
    how: dict[str, Any] = {"workers": cores(workers), "modules": own_modules}
    outcome, find = Outcome(), partial(find_folders, paths, numbered_in)
    if sequences:
        from benchmarks.data.real import real_episodes  # It imports the readers of all layouts.

        refuse("none with real, which has its own truth", truth=truth or None, preset=preset, seeds=seeds)
        episodes, outcome.unusable = real_episodes(wanted, sequences, layout, target, rate_hz, labels_serve=True)
        experiment = Experiment(wanted, episodes, {}, **how)
        files = [SequenceFile(each.sequence, *each.extent, pictures=each.pictures) for each in episodes]
        named = {name for each in files for name in (each.sequence, each.folder)}
        folders = find(named.__contains__, files[0].sequence)
    else:
        check_no_layout(layout, target, rate_hz)
        source = truth or wanted.scenes[0].scenario
        experiment, files, folders = _on_episodes(wanted, source, several("preset", preset), seeds, find, how)
    pairs = list(zip(experiment.episodes, files, strict=True))
    trackers = predicted_trackers(wanted, folders, pairs, format, recorded, trackers_of())
    folder = Path(out or Path("results") / (f"{wanted.name}-real" if sequences else wanted.name))
    silence = wanted.silence_in(REAL if sequences else "")
    return run_all([replace(experiment, trackers=trackers)], folder, outcome, silence, progress)


def _on_episodes(
    wanted: Suite,
    truth: str,
    given_presets: tuple[str, ...],
    seeds: range | None,
    find: Callable[[Callable[[str], bool], str], list[Folder]],
    how: dict[str, Any],
) -> tuple[Experiment, list[SequenceFile], list[Folder]]:
    """Return simulated episodes without trackers, what is known of the file of each, and the folders of trackers.

    Args:
        find: see ``find_folders``. how: see ``Experiment``.
    """
    scenario, presets, renderer, held = _episodes_of(wanted, truth, given_presets)
    names = {set_name(scenario, each, renderer=renderer): each for each in presets}
    numbered = re.compile(rf"(?:{'|'.join(map(re.escape, names))})-(\d{{6,}})")
    chosen: Sequence[int] | None = seeds if seeds is not None else held

    def seed_of(sequence: str) -> int | None:
        match = numbered.fullmatch(sequence)
        return int(match[1]) if match and (chosen is None or int(match[1]) in chosen) else None

    example = sequence_name(next(iter(names)), chosen[0] if chosen else 0)
    folders = find(lambda each: seed_of(each) is not None, example)
    if chosen is None:
        chosen = sorted({seed for each in folders for seed in map(seed_of, each.sequences) if seed is not None})
    by: dict[str, Any] = {"controllers": (SET_PATH,), "renderer": renderer}
    experiment = experiment_on(wanted, scenario, presets, {}, chosen, **by, **how)
    named = {each: prefix for prefix, each in names.items()}
    files = [
        SequenceFile(sequence_name(named[each.preset], each.seed), each.configuration.frame_count)
        for each in experiment.episodes
        if isinstance(each, Simulated)
    ]
    if held is not None:
        # Here, since it imports the packages of the extra.
        from benchmarks.data.sets.benchmark import stored_specs

        check("seeds", set(chosen) <= set(held), f"some of {held.start}:{held.stop}, which the data set has", chosen)
        experiment = replace(experiment, episodes=stored_specs(truth, experiment.episodes))
    return experiment, files, folders


def _check_judged(wanted: Suite, *, pictures: bool) -> None:
    """Raise ValueError for a suite that no file of boxes can be judged in."""
    able = sorted(each.name for each in registry.suites().values() if not (each.judges_controllers or each.needs_depth))
    expected = f"one of {', '.join(able)}"
    check("suite", not wanted.judges_controllers, expected, f"{wanted.name}, whose camera no prediction steers")
    check("suite", not wanted.needs_depth, expected, f"{wanted.name}, which scores tracks with depth_m alone")
    fit = not pictures or wanted.on_sequences is not None
    judging = ", ".join(name for name in able if registry.suite(name).on_sequences is not None)
    check("suite", fit, f"one that judges real pictures ({judging})", wanted.name)


def _episodes_of(wanted: Suite, truth: str, presets: tuple[str, ...]) -> tuple[str, tuple[str, ...], str, range | None]:
    """Return scenario, presets, renderer and seeds of a data set, or of a scenario, whose seeds are None.

    Raises:
        ValueError: for what is neither, or is not of the suite; and for presets that need a controller.
    """
    if "://" in truth or Path(truth).is_dir():
        request = stored_request(truth)
        refuse("none with the truth of a data set, which sets it", preset=presets)
        check("truth", wanted.is_about(request.scenario), f"episodes of suite {wanted.name}", request.scenario)
        return request.scenario, (request.preset,), request.renderer, range(*request.seeds)
    known = [name for name in catalog.names() if wanted.is_about(name)]
    latest = truth if truth in known else next((name for name in known if unversioned(name) == truth), "")
    check("truth", bool(latest), f"one of {', '.join(known)}, or the folder of a data set", repr(truth))
    (choice,) = choices(wanted, scenarios=(latest,), presets=presets, variants=False)
    for preset in choice.presets:
        configuration = catalog.scenario(latest).configuration(preset)
        check("preset", not configuration.closed_loop, "ones on a set path", f"{preset}, whose camera is steered")
    return latest, choice.presets, "raster", None
