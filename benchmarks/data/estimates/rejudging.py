"""Judges kept estimates again: the rows of a run without running its trackers.

Frames with their truth come from a data set, without rendering, or from the same episodes simulated again; in closed
loop by the commands that were obeyed in the run. Rows are those of the run but for ``seconds``, and for what the
present judge does in another way; ``editions`` name the present judge and else what made the estimates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import joblib
import numba
import numpy as np

from benchmarks.contract.judging import Ending, Score, ScoreSheet
from benchmarks.contract.rows import FILE_NAME, REAL, BlockKey, Row, block_key, read_blocks
from benchmarks.contract.suite import suite
from benchmarks.data.estimates.block_file import EXTRAPOLATED, INTERPOLATED, Block, Facts, Values, facts_in, read_block
from benchmarks.data.sets.benchmark import benchmark_of, stored_specs
from benchmarks.data.sets.request import Request
from benchmarks.judges.tracker_speed import frames_seen, times
from benchmarks.run.editions import judge_edition, preset_edition
from benchmarks.run.episodes import simulated
from benchmarks.run.experiment import Progress
from benchmarks.run.guards import FAILED_AT
from benchmarks.run.jobs import CONTROLLER_FAILED_AT, block_of
from benchmarks.run.own_modules import load_modules
from benchmarks.run.result_folder import append_block, tidy
from benchmarks.run.selection import check_renderer
from scenarios.loop import Loop
from sim.checks import check
from trackers.gaps import Bridge, Piece, Surroundings


@dataclass(frozen=True)
class Rejudged:
    """What came of it.

    Attributes:
        same: number of blocks whose rows came out as they were. new: of those that did not, or did not exist.
        moved: message about rows that were replaced, None if none was.
    """

    same: int
    new: int
    moved: str | None


def rejudge(directory: Path, data: str | None, workers: int, modules: tuple[str, ...], progress: Progress) -> Rejudged:
    """Judge all estimates of a result folder again, and write the rows that came out in another way.

    Args:
        data: folder or URL of a data set with the episodes; None = they are simulated again.
        workers: processes; 0 = this process.
        modules: users' own modules to import first.

    Raises:
        ValueError: if there are no estimates; if some are cut off, of other episodes than the rows or the data set, or
            made on frames that the present code does not make.
    """
    load_modules(modules)
    facts = facts_in(directory)
    old = read_blocks(directory) if (directory / FILE_NAME).is_file() else {}
    request = None if data is None else benchmark_of(data)
    for path, each in facts.items():
        _check(str(path), each, old, request)
    calls = (joblib.delayed(_judged)(group, data, modules) for group in _groups(facts))
    done = new = 0
    for blocks in joblib.Parallel(n_jobs=max(workers, 1), return_as="generator", batch_size=1)(calls):
        for block in blocks:
            before = old.get(block_key(block[0]), [])
            # Answers do not hold the time limit that they were given under; the rows do.
            limited = {"limit_s": before[0]["limit_s"]} if before and "limit_s" in before[0] else {}
            block = [row | limited for row in block]
            if _timeless(block) != _timeless(before):
                append_block(directory, block)
                new += 1
        done += len(blocks)
        progress(done, len(facts))
    return Rejudged(done - new, new, tidy(directory))


def _check(path: str, facts: Facts, old: dict[BlockKey, list[Row]], request: Request | None) -> None:
    """Raise ValueError for estimates of other episodes than the rows or the data set."""
    key, editions = facts.key, facts.editions
    check("estimates", key.scenario != REAL, "ones of simulated episodes", f"those of {key.scenario} {key.preset}")
    now, made = preset_edition(key.scenario, key.preset), editions.get("scene")
    check(path, made == now, f"estimates on frames of the scene's present edition, {now}", f"ones of {made}")
    if old:
        named = f"suite {key.suite}, {key.scenario} {key.preset}, seed {key.seed}, tracker {key.tracker}"
        check(path, key in old, f"estimates of a block of rows in {FILE_NAME}", named)
        of_rows = old[key][0]["editions"]
        other = sorted(name for name in of_rows if name != "judge" and of_rows[name] != editions.get(name))
        check(path, not other, f"estimates of the editions that made the rows in {FILE_NAME}", f"another {other}")
    if request is not None:
        for name in ("scenario", "preset", "renderer"):
            own, theirs = getattr(key, name), getattr(request, name)
            check(path, own == theirs, f"estimates of {name} {theirs}, which the data set has", own)
        first, end = request.seeds
        check(path, first <= key.seed < end, f"a seed of {first}:{end}, which the data set has", key.seed)
        check(path, key.controller == "", "a set path, as of stored pictures", f"one steered by {key.controller}")


def _groups(facts: dict[Path, Facts]) -> list[list[Path]]:
    """Return the files of each episode; in closed loop each tracker has an episode of its own."""
    groups: dict[BlockKey, list[Path]] = {}
    for path, each in facts.items():
        key = each.key
        groups.setdefault(key if key.controller else replace(key, tracker=""), []).append(path)
    return [groups[key] for key in sorted(groups)]


def _judged(paths: Sequence[Path], data: str | None, modules: tuple[str, ...]) -> list[list[Row]]:
    """Return the blocks of one episode's files."""
    # As when trackers run.
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(modules)
    blocks = [read_block(path) for path in paths]
    key, frame_count = blocks[0].facts.key, blocks[0].facts.frame_count
    judging = suite(key.suite)
    how: Any = {
        "renderer": check_renderer(key.renderer),
        "controller": key.controller or None,
        "link": key.link or None,
    }
    rendered = simulated(key.scenario, key.preset, key.seed, **how)
    (spec,) = [rendered] if data is None else stored_specs(data, [rendered])
    episode = spec.open(judging.truth)
    try:
        check(str(paths[0]), frame_count == episode.frame_count, f"{episode.frame_count} frames", frame_count)
        judge = spec.judge(judging, episode)
        sheets = [[judge.sheet() for _ in block.answered] for block in blocks]
        loop = Loop(episode, picture_delay_frames=spec.picture_delay_frames)
        for k, command in enumerate(blocks[0].commands):
            frame = loop.step(command)
            judge.see(frame, loop.obeyed)
            for block, own in zip(blocks, sheets, strict=True):
                for answered, sheet in zip(block.answered, own, strict=True):
                    sheet.keep(loop.seen, answered.answers[k])
    finally:
        episode.close()
    return [_rows(block, own) for block, own in zip(blocks, sheets, strict=True)]


def _rows(block: Block, sheets: Sequence[ScoreSheet]) -> list[Row]:
    facts, scores = block.facts, []
    for repeat, (run, answered, sheet) in enumerate(zip(facts.runs, block.answered, sheets, strict=True)):
        gaps = partial(RecalledGapMethod, iter(answered.gaps)) if run.bridges else None
        ending = Ending(run.failed_at_frame, answered.revised, gaps, run.decides_at)
        own = [*sheet.scores(ending), *times(answered.taken, answered.revision, facts.frame_count)]
        if "real_time_hz" in facts.heading:
            own.append(frames_seen(len(answered.taken), facts.frame_count, run.failed_in_the_end))
        if run.failed_in_the_end is not None:
            own.append(Score(FAILED_AT, float(run.failed_in_the_end)))
        scores += [(repeat, score) for score in own]
    if facts.controller_failed_at is not None:
        scores.append((0, Score(CONTROLLER_FAILED_AT, float(facts.controller_failed_at))))
    judging = suite(facts.key.suite)
    ending_columns = {"seconds": None, "editions": facts.editions | {"judge": judge_edition(judging)}}
    return block_of(judging, facts.heading, scores, facts.frame_count, ending_columns)


def _timeless(rows: Sequence[Row]) -> list[Row]:
    return [row | {"seconds": None} for row in rows]


class RecalledGapMethod:
    """Bridges gaps as in the run, see ``GapMethod``."""

    def __init__(self, gaps: Iterator[list[Values]]) -> None:
        """``gaps``: of the run, without those that other methods have answered already."""
        self._gaps = gaps

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn nothing: all answers are known."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._answer(EXTRAPOLATED, past.end_frame, count)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return self._answer(INTERPOLATED, past.end_frame, future.first_frame - past.end_frame)

    def _answer(self, answer: str, first: int, count: int) -> Bridge | None:
        rows = next(self._gaps, [])
        is_same = bool(rows) and (rows[0]["answer"], rows[0]["frame"]) == (answer, first)
        is_none = is_same and rows[0]["track"] is None
        wanted = f"an answer to the gap of {count} frames from frame {first} on, {answer}"
        fits = is_none or (is_same and len(rows) == count)
        check("estimates", fits, wanted, "none, since the judge cut other gaps then")
        if is_none:
            return None
        place_px, covariance_px = ([row[name] for row in rows] for name in ("position_px", "covariance_px"))
        return Bridge(np.array(place_px), None if covariance_px[0] is None else np.array(covariance_px))
