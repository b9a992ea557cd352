"""Checks of names that users choose."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


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
