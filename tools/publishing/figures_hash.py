"""The hash of rows: the same for the same figures, on any machine and in any order."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping, Sequence

from benchmarks.contract.rows import BlockKey, Row
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.selection import trackers_of

_NOT_FIGURES = ("seconds", "editions")
Blocks = Mapping[BlockKey, Sequence[Row]]


def hash_of_figures(blocks: Blocks, left_out: Collection[str]) -> str:
    """Return the SHA-256 of whole blocks of rows, independent of their order.

    Left out are the columns ``seconds`` and ``editions``, and the metrics of the clock. Rows name no path.

    Args:
        left_out: trackers that no seed makes reproducible: ``unrepeatable`` of a new table, or what a table keeps.
    """
    digest = hashlib.sha256()
    for key in sorted(blocks):
        if key.tracker not in left_out:
            digest.update(_figures(blocks[key]))
    return digest.hexdigest()


def differing(first: Blocks, second: Blocks, left_out: Collection[str]) -> list[BlockKey]:
    """Return the blocks whose figures are not the same in both, or that only one has, but for trackers left out."""
    keys = sorted(key for key in {*first, *second} if key.tracker not in left_out)
    return [key for key in keys if _figures(first.get(key, ())) != _figures(second.get(key, ()))]


def unrepeatable(keys: Iterable[BlockKey]) -> frozenset[str]:
    """Return the trackers of blocks whose own random numbers no seed reaches."""
    known = trackers_of()
    return frozenset(key.tracker for key in keys if key.tracker in known and not known[key.tracker].reproducible)


def _figures(rows: Sequence[Row]) -> bytes:
    """Return the rows of one block as text, in their order, which the judge gives them."""
    lines = (
        json.dumps({key: value for key, value in row.items() if key not in _NOT_FIGURES}, sort_keys=True)
        for row in rows
        if row["metric"] not in TIMES
    )
    return "".join(f"{line}\n" for line in lines).encode()
