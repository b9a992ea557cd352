"""Names of episodes as sequences of files: in exports, and in predictions that were made on them."""

from __future__ import annotations

import re


def set_name(scenario: str, preset: str, *, renderer: str = "raster") -> str:
    """Return a name, without dots, for the episodes of a preset: it with what it changes, and another renderer."""
    others = [] if renderer == "raster" else [renderer]
    # Readers take what follows a dot for the ending of a file; a preset's values have brackets, colons and commas.
    return re.sub(r"[^\w-]+", "_", "-".join([scenario, preset, *others])).rstrip("_")


def sequence_name(name: str, seed: int) -> str:
    """Return the name of an episode of a set of that name."""
    return f"{name}-{seed:06d}"
