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
    """Return the known name that ``given`` begins, or the nearest one, as a question in parentheses; else nothing."""
    if not isinstance(given, str):
        return ""
    names = list(known)
    # Of editions of one thing the latest, which is listed last.
    begun = sorted((name for name in reversed(names) if given and name.startswith(given)), key=len)
    near = begun[:1] or difflib.get_close_matches(given, names, 1)
    return f" (did you mean {near[0]}?)" if near else ""
