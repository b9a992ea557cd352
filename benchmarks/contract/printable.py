"""Names of files as text that can be printed and stored."""

from __future__ import annotations

import os


def printable(text: object) -> str:
    r"""Return text or a path with the bytes of names that are not UTF-8 as escapes, e.g. ``M\xe4nn``."""
    return os.fsencode(str(text)).decode(errors="backslashreplace")
