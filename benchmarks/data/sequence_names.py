"""Names of episodes as sequences of files: in exports, and in predictions that were made on them."""

from __future__ import annotations

import hashlib
import re

_LONGEST, _DIGITS = 120, 8
"""Letters of a name; disks have at most 255 for a file, which has a number and an ending besides."""


def set_name(scenario: str, preset: str, *, renderer: str = "raster") -> str:
    """Return a name, without dots, for the episodes of a preset: it with what it changes, and another renderer.

    A long one is cut, and ends with a checksum of all of it.
    """
    others = [] if renderer == "raster" else [renderer]
    # Readers take what follows a dot for the ending of a file; a preset's values have brackets, colons and commas.
    name = re.sub(r"[^\w-]+", "_", "-".join([scenario, preset, *others])).rstrip("_")
    if len(name) <= _LONGEST:
        return name
    return f"{name[: _LONGEST - _DIGITS - 1]}-{hashlib.sha256(name.encode()).hexdigest()[:_DIGITS]}"


def sequence_name(name: str, seed: int) -> str:
    """Return the name of an episode of a set of that name."""
    return f"{name}-{seed:06d}"
