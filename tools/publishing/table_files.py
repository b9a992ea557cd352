"""The committed files of a published table: ``NAME.json``, and its rows as ``NAME.jsonl.xz``.

``NAME.json`` is one object:

===============  =======================================================================================================
``table``        its name
``command``      makes the same rows, without the ledger
``commit``       of the checkout that published them; rows may be of an earlier one, of the same editions
``seeds``        ``A:B``
``editions``     ``shared``: packages and judge; ``scenes``: preset -> scene; ``contestants``: label -> tracker and
                 controller; see ``benchmarks.run.editions``
``rows``         their ``count`` (earlier files have a hash beside it); null for speeds, which have no rows
``failures``     episodes in which a tracker or a controller failed: ``contestant``, ``seed``, ``frame``
``budgets``      of tuned ``trackers`` and ``controllers``: name -> trials, presets and seeds
``summary``      list of ``summary.json``
``findings``     beside the claims of a paper; empty for other tables
``varied``       of a paper: ``words``, ``heads`` and ``rows`` of the table of what was fitted, varied; else null
===============  =======================================================================================================

The rows are ``records.jsonl`` as it was: uncompressed into a folder, ``frameout report`` makes the report from it.
"""

from __future__ import annotations

import json
import lzma
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.cli.arguments import seeds_text
from benchmarks.contract.rows import FILE_NAME, BlockKey, Row, blocks_of_lines, lines_of, read_blocks
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.jobs import CONTROLLER_FAILED_AT
from sim.checks import check
from tools.publishing import ledger
from tools.publishing.tables import PublishedTable
from trackers.atomic_file import write_atomic

_PARTS = ("tracker", "controller", "policy")
"""Parts of editions that are not the same for all rows."""
_FAILED = ("failed_at_frame", CONTROLLER_FAILED_AT)
_NOT_FIGURES = ("seconds", "editions")
Blocks = Mapping[BlockKey, Sequence[Row]]


TableFile = dict[str, Any]
"""What the JSON of a table holds, see the module."""


def write_table(table: PublishedTable, out: Path, commit: str) -> TableFile:
    """Write the files of a table that was made in ``out``; return what they hold.

    Raises:
        ValueError: for rows of several editions; nothing is written then.
    """
    blocks = read_blocks(out) if (out / FILE_NAME).is_file() else {}
    rows = [row for block in blocks.values() for row in block]
    contents = {
        "table": table.name,
        "command": table.command,
        "commit": commit,
        "seeds": seeds_text(table.seeds),
        "editions": editions_of_rows(blocks),
        "rows": {"count": len(rows)} if rows else None,
        "failures": [
            {"contestant": label(row), "seed": row["seed"], "frame": row["value"]}
            for row in rows
            if row["metric"] in _FAILED
        ],
        **table.figures(out, rows),
    }
    ledger.TABLES_FOLDER.mkdir(exist_ok=True)
    if blocks:
        write_atomic(rows_file(table.name), lzma.compress((out / FILE_NAME).read_bytes()))
    else:
        rows_file(table.name).unlink(missing_ok=True)
    write_atomic(table_file(table.name), _as_text(contents))
    return contents


def read_table(name: str) -> TableFile:
    """Return a committed table. Raises ValueError if there is none."""
    check("table", table_file(name).is_file(), "one that was published", repr(name))
    contents: TableFile = json.loads(table_file(name).read_text())
    return contents


def read_rows_of(name: str) -> dict[BlockKey, list[Row]]:
    """Return the committed rows of a table by block; none of a speed, and of a table that is not published."""
    file = rows_file(name)
    return blocks_of_lines(lzma.decompress(file.read_bytes()).splitlines()).blocks if file.is_file() else {}


def begin(table: PublishedTable, out: Path) -> None:
    """Put the committed rows of a table's seeds into a folder without rows; their times may be another machine's."""
    kept = [rows for key, rows in read_rows_of(table.name).items() if key.seed in table.seeds]
    if kept and not (out / FILE_NAME).is_file():
        write_atomic(out / FILE_NAME, b"".join(map(lines_of, kept)))


def differing(first: Blocks, second: Blocks) -> list[BlockKey]:
    """Return the blocks whose figures are not the same in both, or that only one has.

    No figures are the columns ``seconds`` and ``editions``, and the metrics of the clock.
    """
    return [key for key in sorted({*first, *second}) if _figures(first.get(key)) != _figures(second.get(key))]


def _figures(rows: Sequence[Row] | None) -> list[str] | None:
    """Return what is compared of the rows of one block, in their order, which the judge gives them."""
    if rows is None:
        return None
    # As text: NaN is no number that is equal to itself.
    return [
        json.dumps({key: value for key, value in row.items() if key not in _NOT_FIGURES}, sort_keys=True)
        for row in rows
        if row["metric"] not in TIMES
    ]


def table_file(name: str) -> Path:
    """Return the path of a table's JSON."""
    return ledger.TABLES_FOLDER / f"{name}.json"


def rows_file(name: str) -> Path:
    """Return the path of a table's rows."""
    return ledger.TABLES_FOLDER / f"{name}.jsonl.xz"


def editions_of_rows(blocks: Blocks) -> dict[str, Any]:
    """Return the editions of rows, shared and by ``label``. Raises ValueError if there are several of one."""
    found: dict[str, Any] = {"shared": {}, "scenes": {}, "contestants": {}}
    for row in (block[0] for block in blocks.values()):
        name, preset = label(row), row["preset"]
        for part, edition in row["editions"].items():
            if part == "scene":
                known, key, of = found["scenes"], preset, f"the scene of preset {preset}"
            elif part in _PARTS:
                known, key, of = found["contestants"].setdefault(name, {}), part, f"{name}: {part}"
            else:
                known, key, of = found["shared"], part, part
            one = known.setdefault(key, edition) == edition
            check("publish", one, f"rows of one edition of {of}", f"{known[key]}, {edition}")
    return found


def label(row: Mapping[str, Any]) -> str:
    """Return the tracker of a row, or ``CONTROLLER+TRACKER`` where a controller steers."""
    return f"{row['controller']}+{row['tracker']}" if row["controller"] else str(row["tracker"])


def _as_text(contents: TableFile) -> str:
    """Return the JSON with one line for each entry of a list."""
    lines = []
    for key, value in contents.items():
        text = json.dumps(value, ensure_ascii=False)
        if isinstance(value, list) and value:
            entries = (json.dumps(each, ensure_ascii=False) for each in value)
            text = "[\n  " + ",\n  ".join(entries) + "\n ]"
        lines.append(f" {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"
