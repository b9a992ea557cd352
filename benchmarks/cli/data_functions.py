"""``benchmarks.generate``, ``verify``, ``split``, ``merge`` and ``export``: data sets from Python; commands call them.

Each takes the folder or URL of a set, or of one of several parts, and does the same to all of them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.data.exports import exporter
from benchmarks.data.exports.destination import whole_folder
from benchmarks.data.sets import generating, merging
from benchmarks.data.sets.data_set import REQUEST, DataSet, data_sets
from benchmarks.data.sets.description import read_description, requests_of, within
from benchmarks.data.sets.places import new_folder, place_of, put, put_new
from benchmarks.data.sets.request import FORMAT, OnError, Request, part_names
from benchmarks.data.sets.verifying import Problem, problems
from benchmarks.run.experiment import Progress
from benchmarks.run.own_modules import load_modules
from benchmarks.run.workers import cores
from sim.checks import check

Said = Mapping[str, Any] | str | Path
"""A description of a set, or the YAML file that holds it."""


def _silent(done: int, of: int | None) -> None:
    pass


def described(said: Said, on_error: OnError = "stop") -> dict[str, Request]:
    """Return what a description asks for: a request for each part, by its folder, '' for a set without parts.

    Raises:
        ValueError: for whatever no set can be made of; names the part and the key.
    """
    if isinstance(said, Mapping):
        return requests_of(said, on_error)
    try:
        return requests_of(read_description(Path(said)), on_error)
    except ValueError as error:
        raise ValueError(str(error) if str(error).startswith(("config", str(said))) else f"{said}: {error}") from None


def generate(
    said: Said,
    out: str | Path,
    *,
    seeds: range | None = None,
    workers: int | None = None,
    address: str | None = None,
    modules: Sequence[str] = (),
    on_error: OnError = "stop",
    progress: Progress = _silent,
) -> tuple[DataSet, ...]:
    """Make a data set, or what is missing of it.

    Args:
        said: what it is of, e.g. ``{"scenario": "road-town", "episodes": 3, "set": {"frame_count": 20}}``; keys and
            values are those of ``generate --config``.
        out: its folder or URL; parts are in folders of it.
        seeds: make these episodes alone, of each part those that it has; ``merge`` makes the set whole when all are
            there. None = all.
        workers: processes; 0 = this one, None = one for each core. address: of the scheduler of a Dask cluster.
        modules: users' own modules, imported first. on_error: ``skip`` leaves out episodes that cannot be built.

    Returns:
        the parts in order; a set without parts is one.

    Raises:
        ValueError: for whatever no set can be made of, before anything is made; for an ``out`` that holds another one.
    """
    load_modules(tuple(modules))
    requests = described(said, on_error)
    chosen = {name: chosen_of(request, seeds) for name, request in requests.items()}
    wanted = "some that the set has, " + ", ".join("{}:{}".format(*each.seeds) for each in requests.values())
    check("seeds", any(chosen.values()), wanted, seeds)
    begin_parts(str(out), requests)
    makers = generating.Workers(cores(workers), address, tuple(modules))
    places = {name: in_set(out, name) for name in requests}
    for name, request in requests.items():
        generating.begin(request, places[name], chosen[name])
    made, before, total = [], 0, sum(map(len, chosen.values()))
    for name, request in requests.items():
        if chosen[name]:
            of_all = partial(_report_part, progress, before, total)
            made.append(generating.generate(request, places[name], makers, of_all, on_error, chosen[name]))
            before += len(chosen[name])
    return tuple(made)


def _report_part(progress: Progress, before: int, total: int, done: int, of: int) -> None:
    """Tell how much of a whole set is done, by what is done of a part that comes after ``before`` episodes."""
    progress(before + done, total)


def chosen_of(request: Request, seeds: range | None) -> range:
    """Return those of the seeds that a request has."""
    first, end = request.seeds
    return range(first, end) if seeds is None else range(max(first, seeds.start), min(end, seeds.stop))


def begin_parts(out: str, requests: Mapping[str, Request]) -> None:
    """Make the folder of a set of several parts, or check that it is one of the same parts."""
    if "" in requests:
        return
    files, root = place_of(out)
    new_folder(out)
    path = f"{root}/{REQUEST}"
    if not files.exists(path):
        put_new(files, path, (json.dumps({"format": FORMAT, "parts": [*requests]}, indent=1) + "\n").encode())
    found = part_names(files.cat_file(path))
    check("out", found == tuple(requests), f"a set of the parts {', '.join(requests)}", f"{out!r} of {found or 'none'}")


def verify(url: str | Path, progress: Progress = _silent) -> Iterator[tuple[DataSet, Problem]]:
    """Yield what is missing of a data set, and what is damaged. Raises ValueError if there is none."""
    for data in data_sets(str(url)):
        for problem in problems(data, progress):
            yield data, problem


def split(url: str | Path, shares: Mapping[str, float] | None = None) -> dict[str, dict[str, tuple[int, ...]]]:
    """Return the seeds of each split of a data set, for each of its parts, by folder.

    Args:
        shares: ``train``, ``val`` and ``test`` -> share: splits the set anew, and notes it there. No file is moved.

    Raises:
        ValueError: for shares that do not sum to 1, or a set that is not whole yet.
    """
    sets = data_sets(str(url))
    if shares is not None:
        for data in sets:
            check("url", data.is_listed, "a whole set (frameout merge)", data.url)
            request = replace(data.request, splits=dict(shares))
            put(data.files, f"{data.root}/{REQUEST}", request.as_json().encode())
            generating.finish(data.url)
        sets = data_sets(str(url))
    return {data.url: data.splits for data in sets}


def merge(
    folders: str | Path | Sequence[str | Path], out: str | Path | None = None, progress: Progress = _silent
) -> tuple[DataSet, ...]:
    """Make a data set whole that several jobs have made, in one folder or in several.

    Args:
        folders: one folder, or several of the same description with different seeds. out: the folder of what becomes
            of several; None = the one folder.

    Raises:
        ValueError: for missing episodes, for folders of different sets or with the same episodes.
    """
    given = [folders] if isinstance(folders, str | Path) else list(folders)
    sets = [data_sets(str(each)) for each in given]
    names = [[part_of(data, str(url)) for data in parts] for url, parts in zip(given, sets, strict=True)]
    check("directory", all(each == names[0] for each in names), f"sets of the parts {names[0]}", names)
    if out is not None and names[0] != [""]:
        begin_parts(str(out), {name: data.request for name, data in zip(names[0], sets[0], strict=True)})
    made = []
    for name, *parts in zip(names[0], *sets, strict=True):
        place = None if out is None else in_set(out, name)
        made.append(merging.merge([data.url for data in parts], place, progress))
    return tuple(made)


def in_set(out: str | Path, part: str) -> str:
    """Return the folder or URL of a part in that of the set; '' is the set itself."""
    # On a store two slashes are a name between them.
    return f"{str(out).rstrip('/')}/{part}" if part else str(out)


def part_of(data: DataSet, url: str) -> str:
    """Return the folder of a part in the set ``url``; '' for the set itself."""
    return data.url.removeprefix(url).strip("/")


def export(url: str | Path, format: str, out: str | Path, **options: Any) -> int:
    """Write a data set in a format that other programs read (``frameout export --help``), each part in a folder of
    ``out``: all of them or none.

    Args:
        options: ``allow_incomplete``, ``classes``, ``min_visible``, ``min_size_px`` and so on, see
            ``benchmarks.data.exports.exporter.export``.

    Returns:
        the number of objects in pictures that were left out or marked as ignored.

    Raises:
        ValueError: for a set that lacks what the format needs, is damaged or incomplete, or a folder with something.
    """
    parts = {part_of(data, str(url)): data for data in data_sets(str(url))}
    if "" in parts:
        return exporter.export(parts[""], format, out, **options)
    left_out = 0
    with whole_folder(str(out)) as folder:
        for name, data in parts.items():
            with within(name):
                left_out += exporter.export(data, format, folder / name, **options)
    return left_out
