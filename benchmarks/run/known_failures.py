"""Failures of contestants in a results folder: a run that goes on tells those of earlier runs again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.run.failures import Failure
from benchmarks.run.records import BlockKey
from trackers.atomic_file import write_atomic

FILE_NAME = "failures.jsonl"
"""A line for each failure: its attributes and, under ``block``, the key of the rows that it is about."""

Failures = Mapping[BlockKey, Sequence[Failure]]


def read_failures(directory: Path) -> dict[BlockKey, list[Failure]]:
    """Return the failures that a folder keeps, by block. Lines that cannot be read are left out."""
    file = directory / FILE_NAME
    found: dict[BlockKey, list[Failure]] = {}
    for line in file.read_text().splitlines() if file.is_file() else ():
        try:
            told = json.loads(line)
            found.setdefault(BlockKey(**told.pop("block")), []).append(Failure(**told))
        except (ValueError, TypeError, KeyError, AttributeError):
            continue
    return found


def write_failures(directory: Path, failures: Failures) -> None:
    """Write all failures of a folder; without any there is no file."""
    lines = [json.dumps({**asdict(each), "block": asdict(key)}) for key in sorted(failures) for each in failures[key]]
    if lines:
        write_atomic(directory / FILE_NAME, "".join(f"{line}\n" for line in lines))
    else:
        (directory / FILE_NAME).unlink(missing_ok=True)
