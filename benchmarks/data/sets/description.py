"""A set in words: what a file of ``generate --config`` says, what the options of the command say, and what they mean.

The keys are those of a ``Request``, and ``set``, the values of the preset's fields. A file may have ``parts``, each
with keys of its own, which stand before those that it shares with the others::

    preset: quick
    set: {frame_count: 20}
    splits: {train: 0.8, val: 0.2}
    parts:
      town: {scenario: road-town, seeds: 0:100}
      tank: {scenario: fish-tank, episodes: 50}
"""

from __future__ import annotations

import dataclasses
import importlib.metadata
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, cast

import yaml

from benchmarks.contract.text import seed_range
from benchmarks.data.sets.request import OnError, Request, existing_channels, of_seed
from benchmarks.run.editions import package_versions, preset_edition
from benchmarks.run.selection import check_renderer
from scenarios import catalog
from scenarios.field_values import is_drawn, with_values
from sim.checks import check, check_choice

PARTS, NONE = "parts", "none"
_PACKAGES = ("blosc2", "pyarrow")
_TRIED = 1000
"""Episodes whose drawn values are tried beforehand, evenly spread, if there are more."""


class _Texts(yaml.BaseLoader):
    """Reads YAML whose values stay words: 4:24 is a range here, and no 264 in base 60."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        """Return a mapping. Raises ValueError for a key that stands in it twice."""
        names = [self.construct_object(key) for key, _ in node.value]
        twice = next((name for name in names if names.count(name) > 1), None)
        check(f"line {node.start_mark.line + 1}", twice is None, "each key once", f"{twice!r} twice")
        return cast(dict[Any, Any], super().construct_mapping(node, deep))


def read_description(file: Path) -> dict[str, Any]:
    """Return what a YAML file says. Raises ValueError, which names the file, if it cannot be read."""
    try:
        said = yaml.load(file.read_text(encoding="utf-8"), _Texts)
    except OSError as error:
        raise ValueError(f"config: expected a file that can be read, got {str(file)!r}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: expected YAML, got {' '.join(str(error).split())}") from None
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None
    check(str(file), isinstance(said, dict), f"keys with values, e.g. scenario: {catalog.DEFAULT}", repr(said))
    return dict(said)


def requests_of(said: Mapping[str, Any], on_error: OnError = "stop") -> dict[str, Request]:
    """Return the request of each part of a description, by name; that of a set without parts has the name ''.

    Raises:
        ValueError: for whatever no set can be made of, before anything is made; names the part and the key.
    """
    shared = {name: value for name, value in said.items() if name != PARTS}
    parts = _mapping(PARTS, said[PARTS]) if PARTS in said else {"": {}}
    check(PARTS, bool(parts), "one or more", "none")
    words: dict[str, dict[str, Any]] = {}
    for name, own in parts.items():
        with within(name):
            check("name", not name or re.fullmatch(r"[\w-]+", name) is not None, "a word, as of a folder", repr(name))
            words[name] = _merged(shared, _mapping(PARTS, own))
    found: dict[str, Request] = {}
    for name, values in words.items():
        with within(name):
            found[name] = _request_of(values)
    for name, request in found.items():
        with within(name):
            known = {each for one in found.values() for each in catalog.scenario(one.scenario).classes.values()}
            for each in request.classes:
                check_choice("classes", each, sorted(known))
            found[name] = _tried(request, "channels" in words[name], on_error)
    return found


def _request_of(values: Mapping[str, Any]) -> Request:
    """Return the request of keys and values; without channels it has none yet."""
    for key in values:
        check_choice("key", key, _READERS)
    read = {key: reader(key, values[key]) for key, reader in _READERS.items() if key in values}
    check("scenario", "scenario" in read, "a catalogue id (frameout list)", "none")
    check(
        "seeds",
        ("seeds" in read) != ("episodes" in read),
        "either seeds or episodes",
        "both" if "seeds" in read else "none",
    )
    seeds = read.pop("seeds", None) or range(read.pop("episodes"))
    scenario = catalog.scenario(read.pop("scenario"))
    preset = with_values(read.pop("preset", "standard"), read.pop("set", ()))
    versions = package_versions() | {name: importlib.metadata.version(name) for name in _PACKAGES}
    # Its edition is asked for by name, so an unknown name comes first.
    scenario.configuration(preset, seeds.start)
    return Request(
        scenario.id,
        preset,
        (seeds.start, seeds.stop),
        read.pop("channels", ()),
        **read,
        scene=preset_edition(scenario.id, preset),
        packages=versions,
    )


def _tried(request: Request, has_channels: bool, on_error: OnError) -> Request:
    """Return a request with the channels that exist; its first frame is drawn, drawn values are drawn."""
    if is_drawn(request.configuration(), request.preset):
        seeds = range(*request.seeds)
        for seed in seeds[:: max(len(seeds) // _TRIED, 1)]:
            with of_seed(seed):
                request.configuration(seed)
    existing = existing_channels(request, on_error)
    for channel in request.channels:
        check("channels", channel in existing, f"some of {', '.join(existing)}", repr(channel))
    stored = tuple(channel for channel in existing if channel in request.channels or not has_channels)
    return dataclasses.replace(request, channels=stored)


def _merged(shared: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a part: its own before the shared ones; of ``set`` its own fields."""
    merged = {**shared, **own}
    if "set" in shared and "set" in own:
        merged["set"] = {**_mapping("set", shared["set"]), **_mapping("set", own["set"])}
    if {"seeds", "episodes"} & {*own}:
        for key in {"seeds", "episodes"} - {*own}:
            merged.pop(key, None)
    return merged


class within:
    """Name the part of a set in what is wrong with it."""

    def __init__(self, part: str) -> None:
        self.part = part

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if self.part and isinstance(error, ValueError):
            raise ValueError(f"{PARTS}.{self.part}.{error}") from None


def _text(key: str, value: Any) -> str:
    """Return a value as one writes it: numbers, ranges and lists of Python too."""
    if isinstance(value, range):
        return f"{value.start}:{value.stop}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(_text(key, each) for each in value) + "]"
    check(key, not isinstance(value, Mapping) and value not in (None, ""), "a value", repr(value))
    return str(value).lower() if isinstance(value, bool) else str(value)


def _mapping(key: str, value: Any) -> dict[str, Any]:
    check(key, isinstance(value, Mapping), "names with values", repr(value))
    return {str(name): each for name, each in value.items()}


def _settings(key: str, value: Any) -> tuple[str, ...]:
    """Return ``FIELD=VALUE`` for each value; fields of fields are joined by dots."""
    if not isinstance(value, Mapping):
        texts = value if isinstance(value, list | tuple) else [value]
        return tuple(_text(key, each) for each in texts)

    def leaves(within: str, values: Mapping[Any, Any]) -> Iterator[str]:
        for name, each in values.items():
            wanted = "a field's name (a value with commas within { } needs quotes)"
            check(key, re.fullmatch(r"\w+(\.\w+)*", str(name)) is not None, wanted, repr(name))
            if isinstance(each, Mapping):
                yield from leaves(f"{within}{name}.", each)
            else:
                yield f"{within}{name}={_text(f'{key} {within}{name}', each)}"

    return tuple(leaves("", value))


def _names(key: str, value: Any) -> tuple[str, ...]:
    if isinstance(value, list | tuple):
        return tuple(dict.fromkeys(_text(key, each) for each in value))
    return () if _text(key, value) == NONE else tuple(_text(key, value).replace(",", " ").split())


def _seeds(key: str, value: Any) -> range:
    try:
        return seed_range(_text(key, value))
    except ValueError as error:
        raise ValueError(f"{key}: {error}") from None


def _number(key: str, value: Any) -> float:
    try:
        return float(_text(key, value))
    except ValueError:
        raise ValueError(f"{key}: expected a number, got {value!r}") from None


def _switch(key: str, value: Any) -> bool:
    text = _text(key, value)
    check(key, text in ("true", "false"), "true or false", repr(value))
    return text == "true"


def _count(key: str, value: Any) -> int:
    text = _text(key, value)
    check(key, text.isdecimal() and int(text) > 0, "a whole number > 0", repr(value))
    return int(text)


_READERS: Mapping[str, Callable[[str, Any], Any]] = {
    "scenario": _text,
    "preset": _text,
    "set": _settings,
    "seeds": _seeds,
    "episodes": _count,
    "channels": _names,
    "pictures": _text,
    "renderer": lambda key, value: check_renderer(_text(key, value)),
    "background": _switch,
    "splits": lambda key, value: {name: _number(f"{key} {name}", each) for name, each in _mapping(key, value).items()},
    "classes": _names,
    "negatives": _number,
}
"""Key of a description -> what reads its value."""
