"""Keeps what trackers say while a judge judges them, and writes it.

A judge sees every frame, every answer, every obeyed command, and asks the methods that bridge gaps. One that keeps all
of that stands between it and the loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from benchmarks.contract.judging import Ending, Judge, Score, ScoreSheet
from benchmarks.contract.rows import BlockKey, Row
from benchmarks.contract.suite import suite
from benchmarks.data.estimates.block_file import Facts, Run, is_kept, write_block
from benchmarks.data.estimates.columns import (
    AT_ONCE,
    EXTRAPOLATED,
    HINDSIGHT,
    INTERPOLATED,
    TIMES,
    Values,
    row_of_command,
    rows_of_answer,
    rows_of_bridge,
)
from benchmarks.judges.tracker_speed import MS_PER_FRAME
from benchmarks.run.guards import GuardedTracker
from benchmarks.run.jobs import CONTROLLER_FAILED_AT
from benchmarks.run.time_limit import Taken
from scenarios.scenario import Frame
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings
from trackers.types import CameraCommand, Estimate

_OF_SCORES = ("repeat", "metric", "value", "weight", "seconds", "editions")


class KeepingJudge:
    """Another judge that keeps what it passes on to it, see ``benchmarks.contract.judging.Judge``."""

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self._commands: list[Values] = []
        self._sheets: list[_KeepingSheet] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self._commands.append(row_of_command(command))
        self._judge.see(frame, command)

    def sheet(self) -> ScoreSheet:
        """See ``Judge``."""
        self._sheets.append(_KeepingSheet(self._judge.sheet()))
        return self._sheets[-1]

    def write(self, folder: Path, blocks: Sequence[list[Row]], trackers: Sequence[tuple[str, GuardedTracker]]) -> None:
        """Write a file for each of the judged ``blocks``, after their scores.

        Args:
            trackers: tracker and its guard, in the order of the sheets.
        """
        for block in blocks:
            runs = [
                (sheet, guard)
                for sheet, (name, guard) in zip(self._sheets, trackers, strict=True)
                if name == block[0]["tracker"]
            ]
            unnaming = (*_OF_SCORES, suite(block[0]["suite"]).events.key)
            failed = [row["value"] for row in block if row["metric"] == CONTROLLER_FAILED_AT]
            facts = Facts(
                heading={key: value for key, value in block[0].items() if key not in unnaming},
                editions=block[0]["editions"],
                many=runs[0][0].many,
                frame_count=len(self._commands),
                controller_failed_at=int(failed[0]) if failed else None,
                runs=[sheet.run(guard) for sheet, guard in runs],
            )
            timed = {row["repeat"] for row in block if row["metric"] == MS_PER_FRAME}
            rows = (
                {"repeat": repeat, **row}
                for repeat, (sheet, guard) in enumerate(runs)
                for row in sheet.rows(self._commands, guard if repeat in timed else None)
            )
            write_block(folder, list(rows), facts)


@dataclass(frozen=True)
class Estimates:
    """Keeps all answers of a run as tables, see ``benchmarks.run.jobs.Keeper``."""

    def judge(self, judge: Judge) -> KeepingJudge:
        """See ``Keeper``."""
        return KeepingJudge(judge)

    def is_kept(self, folder: Path, key: BlockKey, editions: dict[str, str] | None) -> bool:
        """See ``Keeper``."""
        return is_kept(folder, key, editions)


@dataclass
class _KeepingSheet:
    """One tracker's sheet, and what it said. Attributes: ``many``, see ``Facts``."""

    sheet: ScoreSheet
    many: bool = False
    _answers: list[list[Values]] = field(default_factory=list)
    _gaps: list[Values] = field(default_factory=list)
    _ending: Ending = field(default_factory=Ending)

    def keep(self, frame: Frame, answer: Any) -> None:
        """See ``ScoreSheet``."""
        self.many = not isinstance(answer, Estimate)
        self._answers.append(rows_of_answer(answer))
        self.sheet.keep(frame, answer)

    def scores(self, ending: Ending) -> Iterable[Score]:
        """See ``ScoreSheet``."""
        self._ending, new = ending, ending.new_gap_method
        asked = None if new is None else lambda: _KeepingGapMethod(new(), self._gaps)
        return self.sheet.scores(replace(ending, new_gap_method=asked))

    def run(self, guard: GuardedTracker) -> Run:
        """Return how it went."""
        ending = self._ending
        return Run(
            ending.failed_at_frame,
            guard.failed_at_frame,
            guard.reason,
            ending.decides_at,
            ending.revised is not None,
            ending.new_gap_method is not None,
        )

    def rows(self, commands: Sequence[Values], timed: GuardedTracker | None) -> Iterator[Values]:
        """Yield all that it said, with the times of ``timed``."""
        # No time is taken of the first frame.
        times = {} if timed is None else dict(enumerate(timed.taken, start=1))
        for frame, (command, tracks) in enumerate(zip(commands, self._answers, strict=True)):
            for row in tracks:
                yield {"answer": AT_ONCE, "frame": frame, **row, **command, **_seconds(times.get(frame))}
        revision = None if timed is None else timed.revision
        for frame, answer in enumerate(self._ending.revised or ()):
            for row in rows_of_answer(answer):
                yield {"answer": HINDSIGHT, "frame": frame, **row, **_seconds(revision)}
        yield from self._gaps


def _seconds(taken: Taken | None) -> Values:
    """Return the columns of a time; None = not measured."""
    return dict(zip(TIMES, taken or (None, None), strict=True))


class _KeepingGapMethod:
    """Another method that keeps what it is asked and answers, see ``GapMethod``."""

    def __init__(self, method: GapMethod, kept: list[Values]) -> None:
        self._method, self._kept = method, kept

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""
        self._method.learn(pieces)

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._keep(EXTRAPOLATED, past.end_frame, self._method.extrapolate(past, count, around))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._keep(INTERPOLATED, past.end_frame, self._method.interpolate(past, future, around))

    def _keep(self, answer: str, first: int, bridge: Bridge | None) -> Bridge | None:
        gap = self._kept[-1]["gap"] + 1 if self._kept else 0
        rows = [{}] if bridge is None else rows_of_bridge(bridge.position_px, bridge.covariance_px)
        for k, row in enumerate(rows):
            self._kept.append({"answer": answer, "gap": gap, "frame": first + k, **row})
        return bridge
