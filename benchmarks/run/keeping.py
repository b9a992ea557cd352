"""Keeping of all answers beside the rows: what a run asks of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from benchmarks.contract.judging import Judge
from benchmarks.contract.rows import BlockKey, Row
from benchmarks.run.guards import GuardedTracker


class KeepingJudge(Judge, Protocol):
    """A judge that keeps what it passes on to another one."""

    def write(self, folder: Path, blocks: Sequence[list[Row]], trackers: Sequence[tuple[str, GuardedTracker]]) -> None:
        """Write a file for each of the judged ``blocks``, after their scores.

        Args:
            trackers: tracker and its guard, in the order of the sheets.
        """
        ...


class Keeper(Protocol):
    """Keeps all answers of a run."""

    def judge(self, judge: Judge) -> KeepingJudge:
        """Return a judge of an episode that keeps what it passes on to ``judge``."""
        ...

    def is_kept(self, folder: Path, key: BlockKey, editions: dict[str, str] | None) -> bool:
        """Return whether a block has a whole file, of these ``editions``."""
        ...
