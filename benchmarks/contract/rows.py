"""Rows: the source of every table, plot and page.

``records.jsonl`` holds one JSON object a line. Every row has these keys:

======================  ================================================================================
``suite``               ``frame-out``, ``stereo``, ``fish``, ``harbour``, ``follow``; ``paper`` for experiments that
                        measure a camera and run no tracker
``scenario``, ``preset``  ``road-town-v2``, ``standard`` …; of real tracks ``real`` and the recording's name
``tracker``, ``role``   registry name and role (``ours`` ``variant`` ``as-written`` ``tuned`` ``baseline`` ``blind``
                        ``oracle``); suite ``paper``: ``none`` and ``measured``; suite ``follow``: the
                        *controller's* role (``ours`` ``policy`` ``baseline`` ``variant`` …)
``tracker_role``        suite ``follow`` alone: the role of the tracker
``controller``          name of the controller that steered the camera; null on a set path
``link``                suite ``follow`` alone: how commands reach the carrier, ``scenarios.command_link.LINKS``
``renderer``            ``raster`` or ``pybullet``; ``real`` for recordings
``seed``                the episode's seed; of recordings the number of a block of 500 frames, or of a ``sequence``
``sequence``            of real sequences of pictures: the name of the sequence
``blocks``              of recordings of tracks: how many blocks of time the tracker has there
``modules``             names or files of users' own modules of the run; only where there were any
``process``             of a tracker in its own process: the argument of ``frameout bench --process`` that names it
``predicted``           of predictions made elsewhere: the arguments of ``frameout score`` that name them
``recorded``            of recordings: the arguments of ``frameout bench`` that say which, and how they are read
``real_time_hz``        pictures a second that arrived while trackers worked, see ``run.real_time``; only in real time
``repeat``              0; 0, 1, 2 for trackers that no seed makes reproducible, or as many as ``--repeats``
``metric``              what ``value`` is, see below
``value``               a number; or a list of numbers (a *series*); null = undefined (left out of means)
``weight``              how much the value counts in a mean over rows, e.g. the frames it is a mean of
``frame_out``           suites ``frame-out`` and ``paper``: null for rows about the whole episode; else the attributes
                        of the frame-out that the row is about
``event``               other suites, in place of ``frame_out``: the same of their events
``seconds``             wall time of the episode with this tracker (not reproducible)
``editions``            of scene, judge, tracker, controller and packages that made the row, see ``run.editions``
======================  ================================================================================

Rows of one (suite, scenario, preset, tracker, controller, renderer, link, seed) are one *block*, written at once.
The last row of a block has the metric ``frames`` (number of frames); a block without it was cut off, is
ignored and made again. Replaced rows are moved to ``records.outdated-1.jsonl``, ``-2`` and so on.

What ``metric`` may be, and which attributes events have, stands in the module of each suite's judge, for example
``benchmarks.judges.frame_out.judge``, and beside it in ``fish.gaps.FishGap`` and ``harbour.visits.Visit``. In every
suite there are the times of a tracker (``judges.tracker_speed.times``), ``silent_frames``, ``failed_at_frame`` (only if
the tracker failed), ``controller_failed_at_frame`` (only if the controller failed) and ``frames``. Beside the file lie
``summary.json``, ``comparisons.json`` (``statistics.summary``), the report, ``estimates`` with ``--keep-estimates``.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from sim.checks import check

FILE_NAME = "records.jsonl"
LAST_METRIC = "frames"
REAL: Final = "real"
"""Scenario and renderer of real recordings; preset: recording, or folder of sequences; seed: its block, or sequence."""
ESTIMATES = "estimates"
"""Folder beside the rows with all answers, see ``benchmarks.data.estimates``."""
TEST_SPLIT = range(10_000, 20_000)
"""Seeds of published figures; no parameter is chosen on them."""
HUMAN = "human"
"""Controller in rows of a person who played; the role is ``external``."""

Row = dict[str, Any]
_NAMED: dict[str, Any] = {
    **dict.fromkeys(("suite", "scenario", "preset", "renderer", "tracker", "metric"), str),
    **{"controller": str | None, "seed": int, "value": object},
}


@dataclass(frozen=True, order=True, slots=True)
class BlockKey:
    """Identity of a block of rows: one tracker in one episode. ``link`` is "" in suites without links."""

    suite: str
    scenario: str
    preset: str
    renderer: str
    controller: str
    tracker: str
    seed: int
    link: str = ""


def block_key(row: Row) -> BlockKey:
    """Return the key of a row's block; a set path has the controller ""."""
    where = (row["suite"], row["scenario"], row["preset"], row["renderer"], row["controller"] or "")
    return BlockKey(*where, row["tracker"], row["seed"], row.get("link", ""))


EVENT_COLUMNS = ("event", "frame_out")
"""Columns with the attributes of the event that a row is about; a suite has one of them."""


def event_of(row: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the attributes of a row's event; None for rows about the whole episode."""
    return next((row[name] for name in EVENT_COLUMNS if row.get(name)), None)


@dataclass(frozen=True, slots=True)
class Contents:
    """Contents of a file of rows.

    Attributes:
        blocks: whole blocks in canonical order; the later one of duplicates.
        replaced: lines of blocks that were cut off or made again. broken: lines that are no rows.
    """

    blocks: dict[BlockKey, list[Row]]
    replaced: list[bytes]
    broken: list[bytes]


def read(directory: Path) -> Contents:
    """Return the contents of a directory's rows. Raises ValueError if it holds no records."""
    path = directory / FILE_NAME
    check("directory", path.is_file(), f"one that holds {FILE_NAME}", repr(str(directory)))
    return blocks_of_lines(path.read_bytes().splitlines())


def blocks_of_lines(lines: Iterable[bytes]) -> Contents:
    """Return the contents of the lines of a file of rows."""
    whole: dict[BlockKey, list[tuple[bytes, Row]]] = {}
    growing: list[tuple[bytes, Row]] = []
    replaced: list[tuple[bytes, Row]] = []
    broken: list[bytes] = []
    for line in lines:
        row = _parsed(line)
        if growing and (row is None or block_key(growing[0][1]) != block_key(row)):
            replaced += growing
            growing = []
        if row is None:
            broken.append(line)
            continue
        growing.append((line, row))
        if row["metric"] == LAST_METRIC:
            replaced += whole.get(block_key(row), [])
            whole[block_key(row)] = growing
            growing = []
    blocks = {key: [row for _, row in whole[key]] for key in sorted(whole)}
    return Contents(blocks, [line for line, _ in (*replaced, *growing)], broken)


def read_blocks(directory: Path) -> dict[BlockKey, list[Row]]:
    """Return the whole blocks of a directory, see ``read``."""
    return read(directory).blocks


def read_rows(directory: Path) -> list[Row]:
    """Return all rows of whole blocks in canonical order."""
    return list(itertools.chain.from_iterable(read_blocks(directory).values()))


def lines_of(rows: Sequence[Row]) -> bytes:
    """Return rows as they stand in a file."""
    return "".join(json.dumps(row) + "\n" for row in rows).encode()


def rounded(value: float | list[float] | None) -> float | list[float] | None:
    """Return a value as stored in rows: six significant digits, null if not finite."""
    if isinstance(value, list):
        return [_six_digits(each) for each in value]  # type: ignore[misc]
    return None if value is None else _six_digits(value)


def _six_digits(value: float) -> float | None:
    return float(f"{value:.6g}") if abs(value) < float("inf") else None


def _parsed(line: bytes) -> Row | None:
    """Return the row of a line, None if it is none: torn, not UTF-8, or without the naming columns."""
    try:
        row = json.loads(line.decode())
    except ValueError:
        return None
    whole = isinstance(row, dict) and row.keys() >= _NAMED.keys()
    return row if whole and all(isinstance(row[name], kind) for name, kind in _NAMED.items()) else None
