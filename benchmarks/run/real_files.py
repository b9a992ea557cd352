"""Runs trackers on recordings of real tracks: rows as those of episodes, with blocks of time in place of seeds."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from benchmarks.run.blocks import as_row
from benchmarks.run.contestants import entrant
from benchmarks.run.editions import editions_on_recordings
from benchmarks.run.experiment import Progress, make_folder
from benchmarks.run.failures import Failure
from benchmarks.run.guards import Guard, GuardedGapMethod
from benchmarks.run.outcome import Outcome
from benchmarks.run.records import LAST_METRIC, REAL, Row, append_block, tidy
from benchmarks.scores.summary import write_summary
from benchmarks.suites.judging import Ending, Recording, Score
from benchmarks.suites.registry import Suite, suites
from scenarios.loop import tracker_stream
from sim.checks import check
from trackers import registry
from trackers.protocols import BridgingTracker


def run_on_files(
    suite: Suite,
    files: Sequence[Path],
    trackers: Sequence[str],
    out: Path,
    limit_s: float,
    progress: Progress,
    origin: Row,
) -> Outcome:
    """Run the trackers that bridge gaps on recordings; write rows and summary.

    Rows have the scenario ``real``, the recording as preset, and the number of a block of time as seed, so that
    intervals are those of a bootstrap over blocks. ``origin`` has the columns ``recorded`` and ``modules``.

    Raises:
        ValueError: for a suite that judges no recordings, files that cannot be read, or no tracker that bridges gaps.
    """
    if suite.recordings is None:
        able = sorted(name for name, each in suites().items() if each.recordings or each.on_sequences)
        raise ValueError(f"real: expected a suite that judges recordings ({', '.join(able)}), got {suite.name}")
    check("limit_s", limit_s > 0, "a number of seconds > 0", f"{limit_s:g}")
    makers = {name: registry.entry(name) for name in trackers}
    live = {name: maker.create(tracker_stream(0, name)) for name, maker in makers.items()}
    bridging = {name: each for name, each in live.items() if isinstance(each, BridgingTracker)}
    if not bridging:
        raise ValueError(f"trackers: expected some with a gap method, got {', '.join(trackers) or 'none'}")
    found = suite.recordings(files)
    twice = sorted({one.name for k, one in enumerate(found) if one.name in {each.name for each in found[:k]}})
    check("real", not twice, "recordings of different names", f"two called {', '.join(twice)}")
    make_folder(out)
    outcome, total = Outcome(), len(found) * len(bridging)
    for recording in found:
        for name, tracker in bridging.items():
            guard = Guard(limit_s, "answer")
            ending = Ending(new_gap_method=partial(GuardedGapMethod, tracker.gap_method, guard, 0))
            for block in _blocks(suite, recording, name, ending, origin):
                append_block(out, block)
            if guard.reason is not None:
                outcome.failures.append(
                    Failure(name, REAL, recording.name, 0, 0, guard.reason, "predicted nothing", guard.place)
                )
            outcome.episodes += 1
            progress(outcome.episodes, total)
    outcome.moved += filter(None, [tidy(out)])
    outcome.summary = write_summary(out)
    return outcome


def _blocks(suite: Suite, recording: Recording, tracker: str, ending: Ending, origin: Row) -> list[list[Row]]:
    entered = entrant(tracker)
    heading: Row = {
        "suite": suite.name,
        "scenario": REAL,
        "preset": recording.name,
        "tracker": tracker,
        "role": entered.role,
        "controller": None,
        "renderer": REAL,
        **origin,
    }
    started = time.perf_counter()
    blocks = list(recording.scores(ending))
    editions = editions_on_recordings(suite.name, entered)
    tail = {"seconds": round((time.perf_counter() - started) / max(len(blocks), 1), 3), "editions": editions}
    rows = []
    for number, scores in blocks:
        ends = [*scores, Score(LAST_METRIC, float(recording.block_frames))]
        rows.append([{**heading, "seed": number, **as_row(0, score, suite.events.key), **tail} for score in ends])
    return rows
