"""Failures of contestants in a results folder: a run that goes on tells those of earlier runs again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from benchmarks.contract.rows import BlockKey
from benchmarks.run.failures import ENDED_PROCESS, Failure
from trackers.atomic_file import write_atomic

_EARLIER = "(in an earlier run, whose rows are kept; to run it again, choose another folder)"
FILE_NAME = "failures.jsonl"
"""A line for each failure: its attributes and, under ``block``, the key of the rows that it is about."""


def read_failures(directory: Path) -> dict[BlockKey, list[Failure]]:
    """Return the failures that a folder keeps, by block. Lines that cannot be read are left out."""
    file = directory / FILE_NAME
    found: dict[BlockKey, list[Failure]] = {}
    for line in file.read_bytes().splitlines() if file.is_file() else ():
        try:
            told = json.loads(line)
            key, failure = BlockKey(**told.pop("block")), Failure(**told)
        except (ValueError, TypeError, KeyError, AttributeError):
            continue
        if isinstance(key.seed, int):
            found.setdefault(key, []).append(failure)
    return found


def earlier(failure: Failure) -> Failure:
    """Return a failure of an earlier run, which says so: its cause may be gone, and its rows are kept all the same."""
    return replace(failure, reason=f"{failure.reason} {_EARLIER}")


def write_failures(directory: Path, failures: Mapping[BlockKey, Sequence[Failure]]) -> None:
    """Write all failures of a folder; without any there is no file."""
    lines = [json.dumps({**asdict(each), "block": asdict(key)}) for key in sorted(failures) for each in failures[key]]
    if lines:
        write_atomic(directory / FILE_NAME, "".join(f"{line}\n" for line in lines))
    else:
        (directory / FILE_NAME).unlink(missing_ok=True)


def ended_processes(directory: Path) -> set[str]:
    """Return the contestants that ended their process: to run one again here would end this one."""
    failures = (each for block in read_failures(directory).values() for each in block)
    return {each.tracker for each in failures if each.reason.startswith(ENDED_PROCESS)}
