"""Checks of configured values, and of names that users choose."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Iterable
from itertools import pairwise
from numbers import Integral, Real
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints


def check(name: str, good: bool, expected: str, got: object) -> None:
    """Raise ValueError with the parameter, the expected and the actual value, unless ``good``."""
    if not good:
        raise ValueError(f"{name}: expected {expected}, got {got}")


def check_types(configuration: Any) -> None:
    """Raise ValueError for a field of a dataclass whose value is not of the annotated type.

    NumPy's numbers and lists in place of tuples are accepted; numbers must be finite.
    """
    kinds = get_type_hints(type(configuration))
    for field in dataclasses.fields(configuration):
        value, kind = getattr(configuration, field.name), kinds[field.name]
        if get_origin(kind) is Literal and not _is_of(value, kind):
            check_choice(field.name, value, map(str, get_args(kind)))
        check(field.name, _is_of(value, kind), str(field.type), repr(value))


def check_within(configuration: Any, names: str, low: float, high: float = math.inf, *, above: bool = False) -> None:
    """Raise ValueError for a named field outside [low, high], or outside (low, high] if ``above``.

    A field may be a range, two numbers in ascending order.
    """
    interval = f"{'(' if above else '['}{low:g}, {high:g}{']' if high < math.inf else ')'}"
    for name in names.split():
        value = getattr(configuration, name)
        numbers = value if isinstance(value, tuple | list) else (value,)
        good = all(a <= b for a, b in pairwise((low, *numbers, high))) and not (above and low in numbers)
        wanted = "a number in" if len(numbers) == 1 else "two numbers in ascending order in"
        check(name, good, f"{wanted} {interval}", value)


def _is_of(value: Any, kind: Any) -> bool:
    parts = get_args(kind)
    if get_origin(kind) is Literal:
        return type(value) in (str, int) and value in parts
    if isinstance(kind, UnionType):
        return any(_is_of(value, part) for part in parts)
    if get_origin(kind) is tuple:
        whole = isinstance(value, tuple | list) and (parts[-1] is ... or len(value) == len(parts))
        return whole and all(_is_of(each, parts[0]) for each in value)
    if kind is float:
        return isinstance(value, Real) and math.isfinite(value)
    return isinstance(value, Integral if kind is int else kind)


def check_choice(parameter: str, given: object, known: Iterable[str], *, why: str = "") -> None:
    """Raise ValueError unless ``given`` is a known name; the message lists these, and suggests the nearest one.

    ``why``: it is none of them, in words after the name, in place of a suggestion.
    """
    names = list(known)
    if given in names:
        return
    wanted = f"one of {', '.join(names)}; got" if names else "none, as there are none to choose from, got"
    raise ValueError(f"{parameter}: expected {wanted} {given!r}{why or suggestion(given, names)}")


def suggestion(given: object, known: Iterable[str]) -> str:
    """Return the ``nearest`` known name as a question in parentheses; else nothing."""
    near = nearest(given, known)
    return f" (did you mean {near}?)" if near else ""


def nearest(given: object, known: Iterable[str]) -> str | None:
    """Return the known name that ``given`` begins, or else the one that is most like it, if any is."""
    if not isinstance(given, str):
        return None
    names = list(known)
    # Of editions of one thing the latest, which is listed last.
    begun = sorted((name for name in reversed(names) if given and name.startswith(given)), key=len)
    return next(iter(begun or difflib.get_close_matches(given, names, 1)), None)
