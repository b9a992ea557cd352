"""Failures of trackers and controllers: where, why, what happened then; and those that a folder of results keeps."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import cv2

from benchmarks.contract.rows import REAL, BlockKey
from benchmarks.run.own_inputs import COPY_IT
from trackers.atomic_file import write_atomic

ENDED_PROCESS = "ended its process (killed, crashed or stuck in compiled code)"
"""Reason of a failure that only the next attempt, in another process, can tell."""
_LONGEST = 300
_OF_ARRAYS = (ValueError, cv2.error)
_READ_ONLY = ("read-only", "readonly", "WRITEABLE flag", "Layout of the output array")
"""What NumPy and OpenCV say of an array that may not be changed."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Where and how a tracker failed.

    Attributes:
        tracker, scenario, preset, seed, frame: where; ``tracker`` may be a controller.
        reason: one line. since: what it has done from that frame on.
        place: file and line of a user's own code that raised; empty without.
        sequence: name of the real sequence whose number ``seed`` is; empty in simulated episodes.
    """

    tracker: str
    scenario: str
    preset: str
    seed: int
    frame: int
    reason: str
    since: str = "answered nothing"
    place: str = ""
    sequence: str = ""

    def __str__(self) -> str:
        where = f"{self.scenario} {self.preset}"
        if self.sequence or self.scenario != REAL:  # Tracks have no frames.
            episode = f"sequence {self.sequence}" if self.sequence else f"seed {self.seed}"
            where += f", {episode}, frame {self.frame}"
        place = f" ({self.place})" if self.place else ""
        return f"{self.tracker} failed in {where}: {self.reason}{place}; from there on it has {self.since}"


def reason_of(error: BaseException) -> str:
    """Return an error in one line of at most 300 characters that can be printed, whatever its text is.

    It has the first line of the text; of OpenCV's errors all lines, since the first one says nothing.
    """
    try:
        text = str(error)
    except Exception:
        text = "(it has no text that can be read)"
    line = " ".join(text.split()) if isinstance(error, cv2.error) else next(iter(text.strip().splitlines()), "")
    shown = "".join(letter if letter.isprintable() else " " for letter in line[:_LONGEST])
    is_read_only = isinstance(error, _OF_ARRAYS) and any(words in text for words in _READ_ONLY)
    hint = f"; {COPY_IT}" if is_read_only and COPY_IT not in text else ""
    return f"{type(error).__name__}: {shown}{hint}"


_EARLIER = "(in an earlier run, whose rows are kept; to run it again, choose another folder)"
FILE_NAME = "failures.jsonl"
"""A line for each failure: its attributes and, under ``block``, the key of the rows that it is about."""


def read_failures(directory: Path) -> dict[BlockKey, list[Failure]]:
    """Return the failures that a folder keeps, by block."""
    file = directory / FILE_NAME
    found: dict[BlockKey, list[Failure]] = {}
    for line in file.read_text().splitlines() if file.is_file() else ():
        entry = json.loads(line)
        found.setdefault(BlockKey(**entry.pop("block")), []).append(Failure(**entry))
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
    """Return the trackers that ended their process: to run one again here would end this one."""
    failures = (each for block in read_failures(directory).values() for each in block)
    return {each.tracker for each in failures if each.reason.startswith(ENDED_PROCESS)}
