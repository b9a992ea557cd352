"""Keeps the answers of trackers while a judge judges them, and writes them.

A judge gets every frame, answer and obeyed command, and calls the methods that bridge gaps. One that keeps all of that
stands between it and the loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from benchmarks.contract.judging import Ending, Judge, Score, ScoreSheet
from benchmarks.contract.rows import BlockKey, Row
from benchmarks.contract.suite import suite
from benchmarks.data.estimates import block_file
from benchmarks.data.estimates.block_file import AT_ONCE, EXTRAPOLATED, HINDSIGHT, INTERPOLATED, Facts, Run, Values
from benchmarks.judges.tracker_speed import FRAMES_SEEN, MS_PER_FRAME
from benchmarks.run.guards import GuardedTracker
from benchmarks.run.jobs import CONTROLLER_FAILED_AT
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
        self._commands.append(block_file.row_of_command(command))
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
            heading = block[0]
            judged = zip(self._sheets, trackers, strict=True)
            runs = [(sheet, guard) for sheet, (name, guard) in judged if name == heading["tracker"]]
            unnaming = (*_OF_SCORES, suite(heading["suite"]).events.key)
            failed = [row["value"] for row in block if row["metric"] == CONTROLLER_FAILED_AT]
            facts = Facts(
                heading={key: value for key, value in heading.items() if key not in unnaming},
                editions=heading["editions"],
                many=runs[0][0].many,
                frame_count=len(self._commands),
                controller_failed_at=int(failed[0]) if failed else None,
                runs=[sheet.run(guard) for sheet, guard in runs],
            )
            timed = {row["repeat"] for row in block if row["metric"] in (MS_PER_FRAME, FRAMES_SEEN)}
            rows = [
                {"repeat": repeat, **row}
                for repeat, (sheet, guard) in enumerate(runs)
                for row in sheet.rows(self._commands, guard if repeat in timed else None)
            ]
            block_file.write_block(folder, rows, facts)


@dataclass(frozen=True)
class Estimates:
    """Keeps all answers of a run as tables, see ``benchmarks.run.jobs.Keeper``."""

    def judge(self, judge: Judge) -> KeepingJudge:
        """See ``Keeper``."""
        return KeepingJudge(judge)

    def is_kept(self, folder: Path, key: BlockKey, editions: dict[str, str] | None) -> bool:
        """See ``Keeper``."""
        return block_file.is_kept(folder, key, editions)


@dataclass
class _KeepingSheet:
    """The sheet of one run, and its answers. Attributes: ``many``, see ``Facts``."""

    sheet: ScoreSheet
    many: bool = False
    _answers: list[list[Values]] = field(default_factory=list)
    _gaps: list[Values] = field(default_factory=list)
    _ending: Ending = field(default_factory=Ending)

    def keep(self, frame: Frame, answer: Any) -> None:
        """See ``ScoreSheet``."""
        self.many = not isinstance(answer, Estimate)
        self._answers.append(block_file.rows_of_answer(answer))
        self.sheet.keep(frame, answer)

    def scores(self, ending: Ending) -> Iterable[Score]:
        """See ``ScoreSheet``."""
        self._ending, new = ending, ending.new_gap_method
        keeping = None if new is None else lambda: _KeepingGapMethod(new(), self._gaps)
        return self.sheet.scores(replace(ending, new_gap_method=keeping))

    def run(self, guard: GuardedTracker) -> Run:
        """Return how it went."""
        return Run(
            failed_at_frame=self._ending.failed_at_frame,
            failed_in_the_end=guard.failed_at_frame,
            reason=guard.reason,
            decides_at=self._ending.decides_at,
            revises=self._ending.revised is not None,
            bridges=self._ending.new_gap_method is not None,
        )

    def rows(self, commands: Sequence[Values], timed: GuardedTracker | None) -> Iterator[Values]:
        """Yield the rows of all answers, with the times of ``timed``."""
        taken = timed.taken if timed else {}
        for frame, (command, tracks) in enumerate(zip(commands, self._answers, strict=True)):
            seconds = block_file.row_of_time(taken.get(frame))
            yield from ({"answer": AT_ONCE, "frame": frame, **row, **command, **seconds} for row in tracks)
        seconds = block_file.row_of_time(timed.revision if timed else None)
        for frame, answer in enumerate(self._ending.revised or ()):
            for row in block_file.rows_of_answer(answer):
                yield {"answer": HINDSIGHT, "frame": frame, **row, **seconds}
        yield from self._gaps


class _KeepingGapMethod:
    """Another method, whose answers are kept, see ``GapMethod``."""

    def __init__(self, method: GapMethod, kept: list[Values]) -> None:
        self._kept, self._method = kept, method
        self.learn = method.learn

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._keep(EXTRAPOLATED, past.end_frame, self._method.extrapolate(past, count, around))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._keep(INTERPOLATED, past.end_frame, self._method.interpolate(past, future, around))

    def _keep(self, answer: str, first: int, bridge: Bridge | None) -> Bridge | None:
        gap = self._kept[-1]["gap"] + 1 if self._kept else 0
        rows = enumerate(block_file.rows_of_bridge(bridge), start=first)
        self._kept.extend({"answer": answer, "gap": gap, "frame": frame, **row} for frame, row in rows)
        return bridge
