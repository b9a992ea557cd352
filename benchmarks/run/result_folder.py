"""A folder of results: rows are appended block by block; one run at a time writes, and keeps what is up to date."""

from __future__ import annotations

import fcntl
import itertools
import os
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from benchmarks.contract.rows import FILE_NAME, HUMAN, LAST_METRIC, BlockKey, Row, lines_of, read, read_blocks
from benchmarks.contract.text import time_in_words
from sim.checks import check
from trackers.atomic_file import write_atomic

PROBE = ".writable"
MadeNow = Callable[[BlockKey], dict[str, str] | None]
"""Returns the present ``editions`` of a block of an experiment, None for other blocks."""


def make_folder(out: Path, parameter: str = "out") -> None:
    """Make a folder for results. Raises ValueError, which names the parameter, if it cannot be made or written."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / PROBE
        probe.touch()
        # Another run may begin in the same folder at the same time.
        probe.unlink(missing_ok=True)
    except OSError as error:
        expected = f"{parameter}: expected a folder that can be written"
        raise ValueError(f"{expected}, got {str(out)!r}: {error.strerror}") from None


def check_file(file: Path, parameter: str) -> None:
    """Make the folder of a file. Raises ValueError, which names the parameter, if it fails or the file is a folder."""
    make_folder(file.parent, parameter)
    check(parameter, not file.is_dir(), "a file", f"the folder {str(file)!r}")


@contextmanager
def alone_in(folder: Path, said: str = "", shared: bool = False) -> Iterator[None]:
    """Hold a folder or a file while the context lasts; the system lets go of it when the process ends, however that is.

    Args:
        said: what an error names in its place. shared: whether others may hold it that are ``shared`` too.

    Network disks without such locks hold nothing.

    Raises:
        ValueError: if another process, or another thread of this one, holds it.
    """
    held = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(held, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(
                f"out: expected a folder that no other run writes, got {said or str(folder)!r}, which one writes now"
            ) from None
        except OSError:
            pass
        yield
    finally:
        os.close(held)


def append_block(directory: Path, rows: Sequence[Row]) -> None:
    """Append one whole block: a killed run leaves at most one torn block, at the end.

    Raises:
        ValueError: if the block's last row is not its ``frames`` row.
        OSError: if it cannot be written whole, e.g. on a full disk; nothing of it is left.
    """
    ends = rows[-1]["metric"] if rows else "no rows"
    check("rows", ends == LAST_METRIC, f"a block that ends with the metric {LAST_METRIC!r}", ends)
    path = directory / FILE_NAME
    unwritten = memoryview(lines_of(rows))
    with path.open("ab+", buffering=0) as file:
        end = file.seek(0, os.SEEK_END)
        try:
            if end > 0 and os.pread(file.fileno(), 1, end - 1) != b"\n":
                # A torn line of a killed run must not join our first one.
                file.write(b"\n")
            while unwritten:
                unwritten = unwritten[file.write(unwritten) :]
            os.fsync(file.fileno())
        except OSError as error:
            file.truncate(end)
            error.filename = str(path)
            raise


def up_to_date(
    directory: Path,
    made_now: MadeNow,
    seeds: Collection[int] | None,
    is_outdated: Callable[[BlockKey, Row], bool] = lambda key, row: False,
    run_count: Callable[[BlockKey], int] = lambda key: 1,
    real_time_hz: float | None = None,
) -> tuple[set[BlockKey], list[str]]:
    """Return the blocks of an experiment in a directory that the present editions made, and messages about the others,
    which are moved to another file.

    All blocks of time of a tracker on a recording are one, of seed 0; of those that a stopped run left in part, none is
    kept.

    Args:
        seeds: of the experiment; None = others are no fault.
        is_outdated: takes key and first row of another experiment's block: whether it is moved too.
        run_count: least number of runs of the tracker of one of the experiment's blocks.
        real_time_hz: of the experiment.

    Raises:
        ValueError: for a directory that holds rows of other seeds, or of another ``real_time_hz``.
    """
    if not (directory / FILE_NAME).is_file():
        return set(), []
    blocks = read_blocks(directory)
    if seeds is not None:
        # A person may have played other episodes.
        others = [key.seed for key in blocks if key.controller != HUMAN and key.seed not in seeds]
        wanted = f"a folder with no seeds but {min(seeds)}:{max(seeds) + 1}, e.g. an empty one"
        both = {*seeds, *others}
        if others and len(both) == 1 + max(both) - min(both):
            silence = "sequences without a file of predictions count as silence"
            wanted += f", or give --seeds {min(both)}:{max(both) + 1} ({silence})"
        check("out", not others, wanted, f"{str(directory)!r}, which holds seed {min(others, default=None)}")
    of_times = {rows[0].get("real_time_hz") for rows in blocks.values()}
    held = ", ".join(sorted(map(time_in_words, of_times - {real_time_hz})))
    check("out", not held, f"a folder of rows {time_in_words(real_time_hz)}", f"{str(directory)!r}, of rows {held}")
    groups: dict[BlockKey, list[BlockKey]] = {}
    for key, rows in blocks.items():
        groups.setdefault(replace(key, seed=0) if "blocks" in rows[0] else key, []).append(key)
    have, outdated = set[BlockKey](), set[BlockKey]()
    for whole, keys in groups.items():
        now, heads = made_now(whole), [blocks[key][0] for key in keys]
        runs = 1 + max(row["repeat"] for key in keys for row in blocks[key])
        if now is None:
            outdated.update(key for key, head in zip(keys, heads, strict=True) if is_outdated(whole, head))
        elif runs >= run_count(whole) and all(
            head.get("editions") == now and head.get("blocks", 1) == len(keys) for head in heads
        ):
            have.add(whole)
        else:
            outdated.update(keys)
    return have, list(filter(None, [tidy(directory, outdated)]))


def tidy(directory: Path, outdated: Collection[BlockKey] = ()) -> str | None:
    """Sort the records; move outdated blocks and lines of no whole block to another file.

    Return a message about it, None if nothing was moved.
    """
    contents, message = read(directory), None
    old = b"".join(lines_of(contents.blocks[key]) for key in sorted(outdated))
    aside = [*contents.replaced, *contents.broken, *old.splitlines()]
    if aside:
        names = (directory / f"records.outdated-{number}.jsonl" for number in itertools.count(1))
        beside = next(path for path in names if not path.exists())
        write_atomic(beside, b"\n".join([*aside, b""]))
        message = f"{len(aside)} rows that are outdated, cut off or broken were moved to {beside}"
    kept = (rows for key, rows in contents.blocks.items() if key not in outdated)
    write_atomic(directory / FILE_NAME, b"".join(map(lines_of, kept)))
    return message
