"""One file of estimates: all that one tracker said in one episode, with what a judge has to know beside that.

A file exists whole or not at all. Its bytes are the same for every run of the same code, but for the columns
``cpu_s`` and ``wall_s``.

For metrics of one's own, ``frameout bench --keep-estimates`` leaves a row for each track that a tracker said on each
frame; the columns and their units are those of ``benchmarks.data.estimates.columns.SCHEMA``. The truth of the same
frames is in the tables of a data set of the same scenario, preset and seeds, and nothing has to be run::

    from benchmarks.data.sets.data_set import DataSet
    from benchmarks.data.estimates.block_file import scan

    said = scan("results/mine").to_table(columns=["tracker", "seed", "frame", "repeat", "answer", "position_px"])
    said = said.to_pandas().query("answer == 'at once'")
    true = DataSet("sets/town").table("objects").to_pandas().query("names == 'target'")
    both = said.merge(true, on=["seed", "frame"], suffixes=("", "_true"))
    away_px = np.stack(both["position_px"]) - np.stack(both["position_px_true"])
    both["error_px"] = np.hypot(away_px[:, 0], away_px[:, 1])
    print(both.groupby("tracker")["error_px"].median())
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, astuple, dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet as pq

from benchmarks.contract.rows import ESTIMATES, BlockKey, Row, block_key
from benchmarks.data.estimates.columns import (
    AT_ONCE,
    EXTRAPOLATED,
    HINDSIGHT,
    INTERPOLATED,
    SCHEMA,
    TIMES,
    Types,
    Values,
    answer_of,
    command_of,
    table_of,
    values_of,
)
from benchmarks.run.time_limit import Taken
from sim.checks import check
from trackers.atomic_file import atomic_file
from trackers.types import Answer, CameraCommand

FORMAT = 1
"""Number of the layout of a file; increment it with every change."""
_FACTS = b"frameout_estimates"
_ENDING = ".parquet"


@dataclass(frozen=True)
class Run:
    """How one run of a tracker in an episode went.

    Attributes:
        failed_at_frame: when its answers were judged, see ``Ending``. failed_in_the_end: or on a gap after that.
        reason: of the failure.
        decides_at: see ``Ending``.
        revises, bridges: whether it decided with hindsight, and whether it had a method to bridge gaps.
    """

    failed_at_frame: int | None
    failed_in_the_end: int | None
    reason: str | None
    decides_at: float
    revises: bool
    bridges: bool


@dataclass(frozen=True)
class Facts:
    """What a file says of its whole block.

    Attributes:
        heading: columns of its rows that name it. editions: of its rows.
        many: whether answers are tracks of many targets.
        frame_count: of the episode.
        controller_failed_at: frame, None without a failure.
        runs: by repeat.
        types: of numbers that are not float64.
        format: number of the layout.
    """

    heading: Row
    editions: dict[str, str]
    many: bool
    frame_count: int
    controller_failed_at: int | None
    runs: list[Run]
    types: Types = field(default_factory=dict)
    format: int = FORMAT

    @property
    def key(self) -> BlockKey:
        """Identity of the block."""
        return block_key(self.heading)


@dataclass(frozen=True)
class Answered:
    """All that one run of a tracker answered.

    Attributes:
        answers: on each frame. revised: with hindsight; None if it does not revise.
        gaps: the rows of each of the judge's questions about gaps.
        taken: times of its updates, in order. revision: of the revision.
    """

    answers: list[Answer]
    revised: list[Sequence[Any]] | None
    gaps: list[list[Values]]
    taken: list[Taken]
    revision: Taken


@dataclass(frozen=True)
class Block:
    """A file read whole.

    Attributes:
        facts: of the block. commands: obeyed before each frame. said: by repeat.
    """

    facts: Facts
    commands: list[CameraCommand | None]
    answered: list[Answered]


def path_of(folder: Path, key: BlockKey) -> Path:
    """Return the path of a block's file; the seed and the tracker are for people."""
    digest = hashlib.sha256("/".join(map(str, astuple(key))).encode()).hexdigest()[:12]
    return folder / f"{key.seed:06d}-{quote(key.tracker, safe='')[:80]}-{digest}{_ENDING}"


def write_block(folder: Path, rows: Sequence[Values], facts: Facts) -> None:
    """Write a block's rows."""
    table, types = table_of(rows, facts.heading)
    content = json.dumps(asdict(facts) | {"types": types})
    folder.mkdir(parents=True, exist_ok=True)
    with atomic_file(path_of(folder, facts.key)) as file:
        pq.write_table(table.replace_schema_metadata({_FACTS: content}), file, compression="zstd")


def is_kept(folder: Path, key: BlockKey, editions: dict[str, str] | None) -> bool:
    """Return whether a block has a whole file, of these ``editions``; what judged it does not matter."""
    try:
        kept = facts_of(path_of(folder, key)).editions
    except (FileNotFoundError, ValueError):
        return False
    return editions is not None and kept | {"judge": ""} == editions | {"judge": ""}


def paths_in(directory: Path) -> list[Path]:
    """Return all files in a folder of estimates. Raises ValueError if there are none."""
    paths = sorted(directory.glob(f"[!.]*{_ENDING}"))
    check("estimates", bool(paths), "files of `frameout bench --keep-estimates`", f"none in {str(directory)!r}")
    return paths


def scan(directory: Path | str) -> pyarrow.dataset.Dataset:
    """Return all estimates of a result folder as an Arrow dataset, which reads chosen columns and rows only.

    Raises:
        ValueError: if there are none, or a file is cut off.
    """
    paths = [path for path, _ in facts_in(directory)]
    return pyarrow.dataset.dataset([str(path) for path in paths], schema=SCHEMA, format="parquet")


def facts_in(directory: Path | str) -> list[tuple[Path, Facts]]:
    """Return the files of a result folder's estimates and what each says of its block, e.g. where the tracker failed.

    Raises:
        ValueError: if there are none, or a file is cut off.
    """
    return [(path, facts_of(path)) for path in paths_in(Path(directory) / ESTIMATES)]


def facts_of(path: Path) -> Facts:
    """Return what a file says of its block.

    Raises:
        ValueError: if it is cut off, no file of estimates, or one of another layout.
        FileNotFoundError: if it does not exist.
    """
    try:
        schema = pq.read_schema(path)
        values = json.loads((schema.metadata or {})[_FACTS])
        version = values["format"]
        check(str(path), version == FORMAT, f"estimates of format {FORMAT}", f"format {version}")
        check(str(path), schema.equals(SCHEMA), "the columns of estimates", f"{', '.join(schema.names)}")
        return Facts(**values | {"runs": [Run(**each) for each in values["runs"]]})
    except FileNotFoundError:
        raise
    except (pa.ArrowException, OSError, json.JSONDecodeError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: expected a whole file of estimates, got {_one_line(error)}") from None


def read_block(path: Path) -> Block:
    """Return all of a file. Raises ValueError, see ``facts_of``, also if frames are missing."""
    facts = facts_of(path)
    try:
        table = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{path}: expected a whole file of estimates, got {_one_line(error)}") from None
    rows = values_of(table, facts.types)
    for name in ("suite", "scenario", "preset", "renderer", "tracker", "seed"):
        others = {row[name] for row in rows} - {facts.heading[name]}
        check(str(path), not others, f"rows of {name} {facts.heading[name]!r}", ", ".join(map(repr, others)))
    answered: list[Answered] = []
    first: list[Values] = []
    for repeat, run in enumerate(facts.runs):
        own = [row for row in rows if row["repeat"] == repeat]
        at_once = _by("frame", (row for row in own if row["answer"] == AT_ONCE))
        hindsight = _by("frame", (row for row in own if row["answer"] == HINDSIGHT))
        for answers, wanted in ((at_once, True), (hindsight, run.revises)):
            expected = list(range(facts.frame_count)) if wanted else []
            what = f"answers on frames 0 to {facts.frame_count - 1}" if wanted else "no revised answers"
            check(str(path), list(answers) == expected, what, f"answers on {len(answers)} frames")
        gaps = _by("gap", (row for row in own if row["answer"] in (EXTRAPOLATED, INTERPOLATED)))
        first = first or [each[0] for each in at_once.values()]
        times, revision = (list(map(_taken, some.values())) for some in (at_once, hindsight))
        answered.append(
            Answered(
                [answer_of(each, facts.many) for each in at_once.values()],
                [answer_of(each, many=True) for each in hindsight.values()] if run.revises else None,  # type: ignore[misc]
                list(gaps.values()),
                [taken for taken in times if taken is not None],
                next((taken for taken in revision if taken is not None), Taken(0.0, 0.0)),
            )
        )
    return Block(facts, [command_of(row) for row in first], answered)


def _taken(rows: Sequence[Values]) -> Taken | None:
    """Return the time of an answer; None = not measured."""
    cpu_s, wall_s = (rows[0][name] for name in TIMES)
    return None if cpu_s is None else Taken(cpu_s, wall_s)


def _by(name: str, rows: Iterator[Values]) -> dict[int, list[Values]]:
    """Return rows by the value of a column, in order."""
    groups: dict[int, list[Values]] = {}
    for row in rows:
        groups.setdefault(row[name], []).append(row)
    return groups


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
