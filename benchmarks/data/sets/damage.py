"""Damaged data sets, told in one line."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from pyarrow import ArrowException

_OF_WRITING = (errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EACCES, errno.EPERM)


@contextmanager
def damage_told(root: str, parameter: str = "directory") -> Iterator[None]:
    """Raise ValueError in place of what reading a file of a data set raises that is missing or damaged.

    Args:
        root: place of the data set, which stands in messages about its files. parameter: that named it.
    """
    try:
        yield
    except FileNotFoundError as error:
        # Arrow's names the file alone.
        place = str(error.filename or error)
        if f"{root}/" not in place:
            raise
        raise _damaged(parameter, f"no file {place}") from None
    except (ArrowException, OSError) as error:
        if f"{root}/" not in str(error) or getattr(error, "errno", None) in _OF_WRITING:
            raise
        raise _damaged(parameter, str(error)) from None
    except ValueError as error:
        # The readers begin with the file's path.
        if not str(error).startswith(f"{root}/"):
            raise
        raise _damaged(parameter, str(error)) from None
    except RuntimeError as error:
        # Of blosc2, which does not know the file.
        if "cframe" not in str(error):
            raise
        raise _damaged(parameter, f"pixels that cannot be decoded: {error}") from None


def _damaged(parameter: str, found: str) -> ValueError:
    found = " ".join(found.split())
    return ValueError(f"{parameter}: expected a whole data set (see frameout verify), got {found}")
