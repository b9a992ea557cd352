"""The message about rows that commands ignore."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.contract.rows import FILE_NAME, read


def report_ignored_rows(directory: Path) -> None:
    """Report on stderr how many lines of a folder's rows belong to no whole block, if any.

    Raises:
        ValueError: if the directory holds no records.
    """
    contents = read(directory)
    broken, replaced = len(contents.broken), len(contents.replaced)
    if broken or replaced:
        which = f"{broken} that are no rows, {replaced} of episodes that were cut off or made again later"
        print(f"note: ignored {broken + replaced} lines of {directory / FILE_NAME}: {which}", file=sys.stderr)
