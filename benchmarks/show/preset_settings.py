"""The settings of a scenario's presets: what each means, and its value in each preset."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.show.docstrings import attribute_meanings


@dataclass(frozen=True, slots=True)
class Setting:
    """A setting of presets.

    Attributes:
        name: of the field, with those of the dataclasses that hold it, e.g. ``ego.heading_rad``.
        meaning: from the docstring.
        values: text of a value -> the presets that have it, in their order.
    """

    name: str
    meaning: str
    values: Mapping[str, tuple[str, ...]]


def preset_settings(presets: Mapping[str, Any]) -> list[tuple[tuple[str, ...], list[Setting]]]:
    """Return the settings of presets, those of one kind of dataclass together, each with the presets' names."""
    kinds: dict[type, dict[str, Any]] = {}
    for name, preset in presets.items():
        kinds.setdefault(type(preset), {})[name] = preset
    return [(tuple(mine), list(_settings(mine))) for mine in kinds.values()]


def _settings(presets: Mapping[str, Any], prefix: str = "") -> Iterator[Setting]:
    """Yield the settings of dataclasses of one kind; those of a nested one follow its own."""
    for name, meaning in attribute_meanings(type(next(iter(presets.values())))).items():
        values = {preset: getattr(configuration, name) for preset, configuration in presets.items()}
        nested = {preset: value for preset, value in values.items() if _is_nested(value)}
        yield Setting(prefix + name, meaning, _grouped({p: v for p, v in values.items() if p not in nested}))
        if len({type(value) for value in nested.values()}) == 1:
            yield from _settings(nested, f"{prefix}{name}.")


def _is_nested(value: Any) -> bool:
    return dataclasses.is_dataclass(value) or hasattr(value, "_fields")


def _grouped(values: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    groups: dict[str, list[str]] = {}
    for preset, value in values.items():
        groups.setdefault(value_text(value), []).append(preset)
    return {text: tuple(presets) for text, presets in groups.items()}


def value_text(value: Any) -> str:
    """Return a value as users write it in ``changes``."""
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"({', '.join(map(value_text, value))}{',' if len(value) == 1 else ''})"
    return repr(value)
