"""Presets with other values: ``standard[frame_count=20,traffic_cars=4:24]`` is ``standard`` with two fields changed.

Such a name says all that it changes, so that rows, manifests and files hold it like any preset's. A field has

* a value, as JSON writes it, but words without quotes: ``12``, ``true``, ``grid``, ``[grid,ring]``;
* ``A:B`` or ``uniform(A,B)``: a number drawn for each episode, both ends possible where it is whole;
* ``log_uniform(A,B)`` or ``normal(MEAN,DEVIATION)``, likewise;
* ``choice(X,Y,…)``: one of these values, each as likely.

``A:B`` of a field that is itself a range is this range, and a number is both of its ends. A field of a field has a
dot: ``frame_outs.count=2:3``. What is drawn depends on the episode's seed and the field's name.
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, get_args, get_type_hints

import numpy as np

from sim.checks import check, check_choice
from sim.rng import generator

_NOT_CHANGED = ("summary", "closed_loop")
_NAME = re.compile(r"(?P<preset>[^\[\]]+)\[(?P<values>.*)\]", re.DOTALL)
_CALL = re.compile(r"(?P<kind>[a-z_]+)\((?P<arguments>.*)\)", re.DOTALL)
_NUMBER = r"[-+]?[\d.]+(?:e[-+]?\d+)?"
_SPACED = re.compile(r"\s*([=:,()\[\]])\s*")
"""A space beside one of these says nothing; one between words is part of a value."""
_RANGE = re.compile(rf"({_NUMBER}):({_NUMBER})", re.IGNORECASE)
_DRAWS: Mapping[str, Callable[[np.random.Generator, float, float], float]] = {
    "uniform": lambda rng, low, high: rng.uniform(low, high),
    "log_uniform": lambda rng, low, high: np.exp(rng.uniform(np.log(low), np.log(high))),
    "normal": lambda rng, mean, deviation: rng.normal(mean, deviation),
}


def changeable(preset: Any) -> tuple[str, ...]:
    """Return the fields of a preset, or of a field of one, that take other values, in their order."""
    return tuple(each.name for each in dataclasses.fields(preset) if each.name not in _NOT_CHANGED)


def split_name(name: str) -> tuple[str, dict[str, str]]:
    """Return the preset that a name begins with, and the texts of the values that it changes, by field.

    Raises:
        ValueError: for a text that says no field's value.
    """
    match = _NAME.fullmatch(name)
    return (name, {}) if match is None else (match["preset"], _values(at_commas(match["values"])))


def with_values(name: str, settings: Iterable[str]) -> str:
    """Return the name of a preset with further ``settings``, each ``FIELD=VALUE``, in place of earlier ones.

    Names of the same changes are alike. Raises ValueError for a text that says no field's value.
    """
    preset, values = split_name(name)
    values |= _values(settings)
    changes = ",".join(f"{field}={values[field]}" for field in sorted(values))
    return f"{preset}[{changes}]" if changes else preset


def is_drawn(preset: Any, name: str) -> bool:
    """Return whether a name of a preset with other values draws one for each episode; ``A:B`` of a range does not."""
    for path, text in split_name(name)[1].items():
        usual = preset
        for field in path.split("."):
            usual = getattr(usual, field)
        if _CALL.fullmatch(text) or (_RANGE.fullmatch(text) and not (usual is None or _is_pair(usual))):
            return True
    return False


def changed(preset: Any, values: Mapping[str, str], seed: int, of: str = "") -> Any:
    """Return a preset with other ``values`` of its fields, as they are in the episode of a seed.

    Args:
        of: what the preset is a field of, with a dot.

    Raises:
        ValueError: for an unknown field, a text that is no value of it, and a value that the preset rejects.
    """
    changes: dict[str, Any] = {}
    for name, text in values.items():
        field, _, inner = name.partition(".")
        check_choice("set", field, changeable(preset))
        within = changes.get(field, getattr(preset, field))
        if inner:
            check("set", dataclasses.is_dataclass(within), f"a field without parts: {field}", repr(name))
            changes[field] = changed(within, {inner: text}, seed, f"{of}{field}.")
        else:
            value = _value(of + name, text, within, generator(seed, f"set {of}{name}"))
            if within is None and tuple[float, float] in get_args(get_type_hints(type(preset))[field]):
                check(f"set {of}{name}", value is None or _is_pair(value), "A:B or null", text)
            changes[field] = value
    return dataclasses.replace(preset, **changes)


def _value(name: str, text: str, usual: Any, rng: np.random.Generator) -> Any:
    """Return a field's value of an episode; ``usual`` is that of the preset, whose kind it has."""
    is_pair, ends = _is_pair(usual), _RANGE.fullmatch(text)
    if ends is not None and (is_pair or usual is None):
        # A field that holds nothing may hold a range; numbers of one are no whole numbers.
        return tuple(_like(end, _read(each)) for end, each in zip(usual or (0.0, 0.0), ends.groups(), strict=True))
    value = _drawn(f"set {name}", text, usual[0] if is_pair else usual, rng)
    return (value, value) if is_pair and is_number(value) else value


def _drawn(parameter: str, text: str, usual: Any, rng: np.random.Generator) -> Any:
    """Return the value that a text says, drawn if it says so."""
    call, ends = _CALL.fullmatch(text), _RANGE.fullmatch(text)
    if ends is not None:
        kind, given = "uniform", list(ends.groups())
    elif call is not None:
        kind, given = call["kind"], at_commas(call["arguments"])
    else:
        return _like(usual, _read(text))
    check_choice(parameter, kind, (*_DRAWS, "choice"))
    if kind == "choice":
        return _like(usual, _read(given[rng.integers(len(given))]))
    numbers = [each for each in map(_read, given) if is_number(each)]
    check(parameter, len(numbers) == len(given) == 2, f"two numbers in {kind}", text)
    check(parameter, kind == "normal" or numbers[0] <= numbers[1], "two numbers in ascending order", text)
    check(parameter, kind != "log_uniform" or numbers[0] > 0, "numbers > 0", text)
    check(parameter, kind != "normal" or numbers[1] >= 0, "a deviation >= 0", text)
    check(parameter, is_number(usual), "a value, since it is no number", text)
    if kind == "uniform" and isinstance(usual, int):
        return int(rng.integers(round(numbers[0]), round(numbers[1]) + 1))
    value = float(_DRAWS[kind](rng, *numbers))
    return round(value) if isinstance(usual, int) else value


def _read(text: str) -> Any:
    """Return the value that a text writes as JSON does, but for words, which need no quotes."""
    if text.startswith("[") and text.endswith("]"):
        return [_read(each) for each in at_commas(text[1:-1])] if text != "[]" else []
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def _like(usual: Any, value: Any) -> Any:
    """Return a value in the form of the preset's own: tuples for lists, whole numbers where these are wanted."""
    if is_number(value) and is_number(usual):
        if isinstance(usual, float):
            return float(value)
        return round(value) if isinstance(value, float) and value == round(value) else value
    return with_tuples(usual, value)


def with_tuples(usual: Any, value: Any) -> Any:
    """Return the tuple that a preset holds, which can be hashed, for a list, such as JSON and YAML have."""
    if not isinstance(value, list):
        return value
    values = tuple(with_tuples(None, each) for each in value)
    named = hasattr(usual, "_fields") and len(values) == len(usual)
    return type(usual)(*values) if named else values


def _is_pair(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 2 and all(map(is_number, value))


def is_number(value: Any) -> bool:
    """Return whether a value is a number, which ``True`` is not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _values(settings: Iterable[str]) -> dict[str, str]:
    """Return the text of each value by its field."""
    found = {}
    for each in settings:
        field, equals, text = _SPACED.sub(r"\1", each.strip()).partition("=")
        check("set", bool(field and equals and text), "FIELD=VALUE", repr(each))
        found[field] = text
    return found


def at_commas(text: str) -> list[str]:
    """Split a text at commas that stand in no brackets."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts
