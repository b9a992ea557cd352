"""Reads real recordings: sequences of pictures with boxes, and tracks without pictures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from benchmarks.contract.printable import printable
from benchmarks.contract.suite import Suite, suites
from benchmarks.data.sequences.episode import USUAL_FOCAL, SequenceEpisode
from benchmarks.data.sequences.reading import read_collections
from benchmarks.data.sequences.sequence import USUAL_RATE_HZ
from benchmarks.data.tracks.reading import read_each
from benchmarks.run.real import RealEpisode
from sim.checks import check


def check_no_layout(layout: str, target: int | None, rate_hz: float) -> None:
    """Raise ValueError for arguments of folders of pictures where there are none."""
    told = {"layout": (layout, ""), "target": (target, None), "rate_hz": (rate_hz, USUAL_RATE_HZ)}
    for name, (mine, default) in told.items():
        check(name, mine == default, "none but with --real and a suite that judges pictures", repr(str(mine)))


def real_episodes(
    suite: Suite, paths: Sequence[Path], layout: str, target: int | None, rate_hz: float
) -> tuple[tuple[RealEpisode, ...], list[str]]:
    """Return the sequences or recordings of paths, and what is wrong with those that cannot be read, a line each.

    What a user should know of how they were read is printed to stderr.

    Raises:
        ValueError: for a suite that judges nothing real, and if nothing can be read.
    """
    if suite.on_sequences is None:
        check_no_layout(layout, target, rate_hz)
    words = ["--layout", layout] if layout else []
    words += [] if target is None else ["--target", str(target)]
    words += [] if rate_hz == USUAL_RATE_HZ else ["--rate-hz", f"{rate_hz:g}"]
    recorded = ("--real", *map(printable, paths), *words)
    if suite.on_sequences is not None:
        collections = read_collections(paths, layout, target, rate_hz)
        notes = [f"the sequences tell no focal length: {USUAL_FOCAL:g} times the longer side of the picture is taken"]
        notes += [note for each in collections for sequence in each.sequences for note in sequence.notes]
        unusable = [line for each in collections for line in each.unusable]
        found = [
            RealEpisode(each.name, one.number, one, partial(SequenceEpisode, one), recorded)
            for each in collections
            for one in each.sequences
        ]
    elif suite.recordings is not None:
        tables, unusable = read_each(paths)
        recordings, notes, unjudged = suite.recordings(tables)
        unusable += unjudged
        if not recordings:
            raise ValueError(unusable[0])
        found = [RealEpisode(each.name, 0, each, None, recorded) for each in recordings]
    else:
        able = sorted(name for name, each in suites().items() if each.recordings or each.on_sequences)
        raise ValueError(f"real: expected a suite that judges recordings ({', '.join(able)}), got {suite.name}")
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return tuple(found), unusable
