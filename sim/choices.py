"""Checks of names that users choose."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def check_choice(parameter: str, given: str, known: Iterable[str], *, why: str = "") -> None:
    """Raise ValueError unless ``given`` is a known name; the message lists these, and suggests the nearest one.

    ``why``: it is none of them, in words after the name, in place of a suggestion.
    """
    names = list(known)
    if given in names:
        return
    near = difflib.get_close_matches(given, names, 1)
    suggestion = f" (did you mean {near[0]}?)" if near else ""
    raise ValueError(f"{parameter}: expected one of {', '.join(names)}; got {given!r}{why or suggestion}")
