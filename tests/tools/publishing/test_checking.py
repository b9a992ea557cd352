"""A published table is made again, and what differs is found."""

from __future__ import annotations

import copy
import json
import lzma
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract.rows import BlockKey, Row, block_key
from tests.benchmarks.fake_rows import rows_of
from tests.tools.publishing.conftest import SMOKE, contents, publish
from tools.publishing import ledger
from tools.publishing.table_files import differing
from tools.publishing.tables import BenchTable, SpeedTable

pytestmark = pytest.mark.usefixtures("smoke")
Blocks = dict[BlockKey, list[Row]]


@pytest.mark.heavy
def test_a_fresh_run_has_the_same_figures_and_a_changed_row_is_found(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(tmp_path / "out") == 0
    assert publish(tmp_path / "other", "smoke", "--check") == 0
    assert "smoke: the same figures on seeds 0:2" in capsys.readouterr().out
    file = ledger.TABLES_FOLDER / "smoke.jsonl.xz"
    rows = [json.loads(line) for line in lzma.decompress(file.read_bytes()).splitlines()]
    row = next(row for row in rows if row["metric"] == "outside_error_px" and row["seed"] == 1)
    row["value"] += 1e-3
    file.write_bytes(lzma.compress("".join(json.dumps(each) + "\n" for each in rows).encode()))
    monkeypatch.setattr("tools.publish.calculates_like_published", lambda _: False)
    assert publish(tmp_path / "other", "--check", "--episodes", "1") == 0
    printed = capsys.readouterr()
    assert "on seeds 0:1" in printed.out
    assert "note: figures may differ" in printed.err
    assert publish(tmp_path / "other", "--check") == 1
    assert f"smoke: {row['tracker']} has other figures on 1 seeds, first on 1" in capsys.readouterr().out
    file.unlink()
    assert publish(tmp_path / "other", "--check") == 1
    assert not (tmp_path / "other").exists()


def test_what_cannot_be_compared_is_named(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert publish(tmp_path / "out") == 0
    listed(replace(SMOKE, seeds=range(3)))
    assert publish(tmp_path / "out", "--check") == 2
    assert "tables: expected smoke as published" in capsys.readouterr().err
    (ledger.TABLES_FOLDER / "fast.json").write_text(json.dumps({**contents(), "rows": None}))
    fast = SpeedTable(name="fast", scenario=SMOKE.scenario, preset="quick", seeds=range(1))
    listed(fast, SMOKE, replace(SMOKE, name="later"))
    assert publish(tmp_path / "out", "--check") == 0
    printed = capsys.readouterr()
    assert "smoke: the same figures" in printed.out
    assert "note: without published rows, and not checked: fast, later" in printed.err
    monkeypatch.setattr(BenchTable, "make", lambda *_: pytest.fail("ran before all were looked at"))
    for last in ("fast", "later"):
        assert publish(tmp_path / "out", "smoke", last, "--check") == 2
        assert last in capsys.readouterr().err


@pytest.mark.heavy
def test_another_table_of_what_was_fitted_is_found(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    figures = BenchTable.figures

    def varied(figure: str) -> Callable[..., dict[str, Any]]:
        table = {"words": "varied", "heads": ("what", "found"), "rows": (("threshold × 2", figure),)}
        return lambda *given: figures(*given) | {"varied": table}

    monkeypatch.setattr(BenchTable, "figures", varied("0.7"))
    assert publish(tmp_path / "out") == 0
    assert contents()["varied"]["rows"] == [["threshold × 2", "0.7"]]
    assert publish(tmp_path / "other", "--check") == 0
    capsys.readouterr()
    monkeypatch.setattr(BenchTable, "figures", varied("0.6"))
    assert publish(tmp_path / "other", "--check") == 1
    assert "smoke: the table of what was fitted, varied, has other figures" in capsys.readouterr().out


@pytest.fixture
def blocks() -> Blocks:
    made = [rows_of(tracker, seed) for tracker in ("sharp", "hold") for seed in (1, 2, 10)]
    return {block_key(rows[0]): rows for rows in made}


def changed(blocks: Blocks, metric: str, **columns: Any) -> Blocks:
    """Return the blocks with other columns in the first row of a metric."""
    copied = copy.deepcopy(blocks)
    row = next(row for rows in copied.values() for row in rows if row["metric"] == metric)
    row.update(columns)
    return copied


@pytest.mark.parametrize(
    ("metric", "columns", "count"),
    [
        ("frames", {"seconds": 99.0}, 0),
        ("frames", {"editions": {"numpy": "1"}}, 0),
        ("frames_per_s", {"value": 1.0}, 0),
        ("recovered", {"value": 0.123456}, 1),
        ("recovered", {"value": None}, 1),
        ("recovered", {"weight": 2.0}, 1),
        ("recovered", {"frame_out": None}, 1),
        ("recovered", {"role": "oracle"}, 1),
    ],
)
def test_every_figure_counts_and_clock_and_code_do_not(
    blocks: Blocks, metric: str, columns: dict[str, Any], count: int
) -> None:
    assert len(differing(changed(blocks, metric, **columns), blocks)) == count


def test_a_block_or_a_row_that_is_missing_counts(blocks: Blocks) -> None:
    key = next(iter(blocks))
    without = {each: rows for each, rows in blocks.items() if each != key}
    assert differing(without, blocks) == differing(blocks, without) == [key]
    assert differing({**blocks, key: blocks[key][1:]}, blocks) == [key]
