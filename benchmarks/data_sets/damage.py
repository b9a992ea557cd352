"""Damaged data sets, told in one line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pyarrow import ArrowException


@contextmanager
def damage_told(root: str, parameter: str = "directory") -> Iterator[None]:
    """Raise ValueError in place of what the readers of a data set raise for a file that is missing or damaged.

    Args:
        root: place of the data set, which stands in their messages. parameter: that named it.
    """
    try:
        yield
    except (ArrowException, FileNotFoundError, ValueError) as error:
        found = " ".join(str(error).split())
        if isinstance(error, FileNotFoundError):
            # Arrow's names the file alone.
            found = f"no file {error.filename or found}"
        # The readers name a damaged file by its path.
        if f"{root.lstrip('/')}/" not in found or found.startswith(f"{parameter}: "):
            raise
        raise ValueError(f"{parameter}: expected a whole data set (see frameout verify), got {found}") from None
