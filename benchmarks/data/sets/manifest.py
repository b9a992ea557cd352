"""The list of a whole set: a row an episode, with sizes and checksums of its files, in one Parquet table.

It is written once, from the marks of all episodes. Until then, and while a job adds to the set, marks are read.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from fsspec import AbstractFileSystem
from pyarrow import ArrowException

from benchmarks.data.sets.episode_writer import MARK, read_marks
from benchmarks.data.sets.places import whole_file
from benchmarks.data.sets.request import Request

MANIFEST = "manifest.parquet"
_FILE = pa.struct([("name", pa.string()), ("bytes", pa.int64()), ("sha256", pa.binary(32))])
_SCHEMA = pa.schema(
    [
        ("seed", pa.int64()),
        ("split", pa.string()),
        ("frame_count", pa.int32()),
        # Why it could not be built; null of those that were.
        ("left_out", pa.string()),
        ("files", pa.list_(_FILE)),
    ]
)
_ROWS_AT_ONCE = 4096


@dataclass(frozen=True)
class Entry:
    """An episode of the list.

    Attributes:
        files: name -> size and SHA-256 of each of its files, the mark too.
    """

    seed: int
    frame_count: int
    files: dict[str, tuple[int, bytes]]


def entry_of(seed: int, mark: bytes) -> Entry:
    """Return the entry that an episode's mark says."""
    said = json.loads(mark)
    files = files_of(said) | {MARK: (len(mark), hashlib.sha256(mark).digest())}
    return Entry(seed, said["frame_count"], files)


def files_of(said: Mapping[str, Any]) -> dict[str, tuple[int, bytes]]:
    """Return size and SHA-256 of each file that a mark names."""
    return {name: (each["bytes"], bytes.fromhex(each["sha256"])) for name, each in said["files"].items()}


def entries_of_marks(files: AbstractFileSystem, root: str, seeds: Sequence[int]) -> Iterator[Entry]:
    """Yield the episodes that were written to their ends, in the order of seeds."""
    for seed, mark in read_marks(files, root, seeds):
        yield entry_of(seed, mark)


def write_manifest(files: AbstractFileSystem, root: str, request: Request, left_out: Mapping[int, str]) -> list[int]:
    """Write the list, unless episodes of the request are missing: return their seeds."""
    missing: list[int] = []
    seeds = iter(range(*request.seeds))
    with whole_file(files, f"{root}/{MANIFEST}") as file, pq.ParquetWriter(file, _SCHEMA, compression="zstd") as table:
        while some := list(islice(seeds, _ROWS_AT_ONCE)):
            found = {each.seed: each for each in entries_of_marks(files, root, some)}
            rows = []
            for seed in some:
                row: dict[str, Any] = {"seed": seed, "split": request.split_of(seed), "frame_count": 0, "files": []}
                if seed in found:
                    row["frame_count"] = found[seed].frame_count
                    listed = sorted(found[seed].files.items())
                    row["files"] = [{"name": name, "bytes": size, "sha256": sha} for name, (size, sha) in listed]
                elif seed in left_out:
                    row["left_out"] = left_out[seed]
                else:
                    missing.append(seed)
                rows.append(row)
            table.write_table(pa.Table.from_pylist(rows, _SCHEMA))
    if missing:
        files.rm_file(f"{root}/{MANIFEST}")
    return missing


def read_manifest(files: AbstractFileSystem, root: str, columns: list[str] | None = None) -> pa.Table | None:
    """Return the list, None if there is none. Raises ValueError if it is damaged."""
    path = f"{root}/{MANIFEST}"
    if not files.exists(path):
        return None
    try:
        with files.open(path, "rb") as file:
            return pq.read_table(file, columns=columns)
    except (ArrowException, OSError) as error:
        why = " ".join(str(error).split())
        raise ValueError(f"{MANIFEST}: expected the list of a data set's episodes, got {why}") from None


def entries_of_manifest(files: AbstractFileSystem, root: str) -> Iterator[Entry]:
    """Yield the listed episodes; a part of the list is in memory at once."""
    with files.open(f"{root}/{MANIFEST}", "rb") as file:
        for batch in pq.ParquetFile(file).iter_batches(_ROWS_AT_ONCE, columns=["seed", "frame_count", "files"]):
            for row in batch.to_pylist():
                if row["files"]:
                    listed = {each["name"]: (each["bytes"], each["sha256"]) for each in row["files"]}
                    yield Entry(row["seed"], row["frame_count"], listed)


def left_out_in(listed: pa.Table | None) -> dict[int, str]:
    """Return the seeds of a list whose episodes could not be built, and why."""
    if listed is None:
        return {}
    few = listed.filter(pc.is_valid(listed["left_out"]))
    return dict(zip(few["seed"].to_pylist(), few["left_out"].to_pylist(), strict=True))


def left_out_before(files: AbstractFileSystem, root: str) -> dict[int, str]:
    """Return the seeds that a set of format 2 or 3 left out, and why; its list was JSON."""
    path = f"{root}/manifest.json"
    listed = json.loads(files.cat_file(path)).get("left_out", {}) if files.exists(path) else {}
    return {int(seed): str(why) for seed, why in listed.items()}
