"""Runs trackers on real sequences of pictures: rows as those of episodes, with sequences in place of seeds."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numba

from benchmarks.run.blocks import as_block
from benchmarks.run.contestants import Entrant, contestant_of_one, entrants
from benchmarks.run.editions import editions_on_recordings
from benchmarks.run.experiment import Progress, make_folder
from benchmarks.run.failures import Failure
from benchmarks.run.guards import GuardedContestant, guarded
from benchmarks.run.jobs import take_in
from benchmarks.run.outcome import Outcome
from benchmarks.run.process_state import ProcessState
from benchmarks.run.records import FILE_NAME, REAL, BlockKey, Row, append_block, read_blocks, tidy
from benchmarks.scores.summary import write_summary
from benchmarks.sequences.episode import USUAL_FOCAL, SequenceEpisode
from benchmarks.sequences.odd_boxes import odd_boxes
from benchmarks.sequences.sequence import BoxedSequence, Collection
from benchmarks.suites.registry import Suite
from scenarios.loop import Loop, tracker_stream
from sim.checks import check

_NEED_TRUTH = ("blind", "oracle")
"""Roles whose contestants are given the true state in metres."""


@dataclass(frozen=True)
class _Run:
    """What is run on every sequence.

    Attributes:
        suite: that judges. trackers: by name. editions: of their rows.
        repeats: runs of a tracker that no seed makes reproducible. limit_s: for one frame.
        origin: common columns of the rows, of users' modules and of the arguments that say what is read.
    """

    suite: Suite
    trackers: dict[str, Entrant]
    editions: dict[str, dict[str, str]]
    repeats: int
    limit_s: float
    origin: Row

    def key(self, collection: Collection, number: int, tracker: str) -> BlockKey:
        """Return the identity of a tracker's block on a sequence."""
        return BlockKey(self.suite.name, REAL, collection.name, REAL, "", tracker, number, "")


def trackers_on_pictures(suite: Suite) -> dict[str, Entrant]:
    """Return the trackers of a suite that need nothing but pictures, by name."""
    return {name: each for name, each in entrants(suite.name).items() if each.role not in _NEED_TRUTH}


def run_on_sequences(
    suite: Suite,
    collections: Sequence[Collection],
    trackers: Sequence[str],
    out: Path,
    repeats: int,
    limit_s: float,
    progress: Progress,
    origin: Row,
) -> Outcome:
    """Run trackers on the sequences that lack rows of the present editions, in this process; write rows and summary.

    Rows have the scenario ``real``, the collection as preset, and the number of the sequence in it as seed, so that
    intervals are those of a bootstrap over sequences. The same call after a stop continues. ``origin`` has the columns
    ``recorded`` and ``modules``.

    Raises:
        ValueError: for an unknown tracker or one that needs the truth, and for a picture that is broken.
    """
    expected = trackers_on_pictures(suite)
    for name in trackers:
        check("trackers", name in expected, f"some of {', '.join(expected)}, which need pictures alone", repr(name))
    check("limit_s", limit_s > 0, "a number of seconds > 0", f"{limit_s:g}")
    make_folder(out)
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    chosen = {name: expected[name] for name in trackers}
    editions = {name: editions_on_recordings(suite.name, each) for name, each in chosen.items()}
    run = _Run(suite, chosen, editions, repeats, limit_s, origin)
    have, outdated = _stored(run, collections, out)
    outcome = Outcome(resumed=len(have))
    total = len(chosen) * sum(len(each.sequences) for each in collections)
    unknown = f"{USUAL_FOCAL:g} times the longer side of the picture is taken"
    print(f"note: the sequences tell no focal length: {unknown}", file=sys.stderr)
    for odd in odd_boxes(collections):
        print(f"note: {odd}", file=sys.stderr)
    progress(len(have), total)
    for collection in collections:
        for number, sequence in enumerate(collection.sequences):
            missing = [name for name in chosen if run.key(collection, number, name) not in have]
            if missing:
                try:
                    for block in _blocks(run, collection, number, sequence, missing, outcome):
                        append_block(out, block)
                except ValueError as error:
                    if not have and not outcome.episodes:
                        raise
                    kept = "the rows made before are kept, and once it is mended the same command continues"
                    raise ValueError(f"{error}; {kept}") from error
                outcome.episodes += len(missing)
                progress(len(have) + outcome.episodes, total)
    outcome.silent = +outcome.silent
    outcome.moved += filter(None, [tidy(out, outdated)])
    outcome.summary = write_summary(out)
    return outcome


def _stored(run: _Run, collections: Sequence[Collection], out: Path) -> tuple[set[BlockKey], set[BlockKey]]:
    """Return the blocks of these sequences that present editions made, and those of sequences that have changed.

    Blocks of other editions are made again, which replaces them.
    """
    blocks = read_blocks(out) if (out / FILE_NAME).is_file() else {}
    now = {(each.name, k): one.fingerprint for each in collections for k, one in enumerate(each.sequences)}
    names = {each.name for each in collections}
    mine = {key for key in blocks if (key.suite, key.scenario) == (run.suite.name, REAL) and key.preset in names}
    outdated = {key for key in mine if blocks[key][0].get("recording") != now.get((key.preset, key.seed))}
    made = {key for key in mine - outdated if blocks[key][0].get("editions") == run.editions.get(key.tracker)}
    again = {
        run.key(each, k, name) for each in collections for k in range(len(each.sequences)) for name in run.trackers
    }
    return made, outdated - again


@dataclass
class _Watcher:
    """One run of one tracker on a sequence."""

    name: str
    repeat: int
    guard: GuardedContestant


def _blocks(
    run: _Run, collection: Collection, number: int, sequence: BoxedSequence, names: Sequence[str], outcome: Outcome
) -> Iterator[list[Row]]:
    """Run trackers on one sequence, whose pictures are read once for all; yield the rows of each."""
    judging = run.suite.on_sequences
    assert judging is not None
    started = time.perf_counter()
    episode = SequenceEpisode(sequence)
    watchers = [each for name in names for each in _watchers(run, number, name)]
    judge = judging.judge(episode)
    sheets = [judge.sheet() for _ in watchers]
    loop = Loop(episode, [each.guard for each in watchers])
    for _ in loop.frames():
        take_in(loop, judge, sheets)
    seconds = round((time.perf_counter() - started) / len(names), 3)
    for name in names:
        mine = [(each, sheet) for each, sheet in zip(watchers, sheets, strict=True) if each.name == name]
        scores = [
            (each.repeat, score)
            for each, sheet in mine
            for score in (*sheet.scores(each.guard.ending()), *each.guard.scores())
        ]
        heading = _heading(run, collection, number, sequence, name)
        tail = {"seconds": seconds, "editions": run.editions[name]}
        yield as_block(heading, scores, None, len(sequence.pictures), run.suite.events.key, tail)
    for each in watchers:
        guard = each.guard
        guard.close()
        outcome.oddities.add(each.name, guard.watch, guard.left)
        if guard.failed_at_frame is None:
            outcome.silent[each.name] += guard.silent_frames
        else:
            where = (each.name, REAL, f"{collection.name} {sequence.name}", number, guard.failed_at_frame)
            outcome.failures.append(Failure(*where, str(guard.reason), place=guard.place))


def _watchers(run: _Run, number: int, name: str) -> Iterator[_Watcher]:
    for repeat in range(1 if run.trackers[name].reproducible else run.repeats):
        with (state := ProcessState()).applied():
            contestant = contestant_of_one(name, tracker_stream(number, name, repeat))
        yield _Watcher(name, repeat, guarded(contestant, run.limit_s, state=state))


def _heading(run: _Run, collection: Collection, number: int, sequence: BoxedSequence, tracker: str) -> Row:
    return {
        "suite": run.suite.name,
        "scenario": REAL,
        "preset": collection.name,
        "tracker": tracker,
        "role": run.trackers[tracker].role,
        "controller": None,
        "renderer": REAL,
        "seed": number,
        "sequence": sequence.name,
        "recording": sequence.fingerprint,
        **run.origin,
    }
