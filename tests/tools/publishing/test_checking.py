"""A published table is made again, and what differs is found."""

from __future__ import annotations

import json
import lzma
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.tools.publishing.conftest import SMOKE, contents, publish
from tools.publishing import ledger, table_files
from tools.publishing.published import PublishedTable
from tools.publishing.table_runs import BenchRun

pytestmark = pytest.mark.usefixtures("smoke", "unmeasured")


@pytest.mark.heavy
def test_a_fresh_run_has_the_same_figures_and_a_changed_row_is_found(
    checkout: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(tmp_path / "out") == 0
    assert publish(tmp_path / "other", "smoke", "--check") == 0
    assert "smoke: the same figures on seeds 0:2" in capsys.readouterr().out
    assert publish(tmp_path / "other", "smoke", "--check", "--episodes", "1") == 0
    assert "on seeds 0:1" in capsys.readouterr().out

    file = ledger.TABLES_FOLDER / "smoke.jsonl.xz"
    rows = [json.loads(line) for line in lzma.decompress(file.read_bytes()).splitlines()]
    row = next(row for row in rows if row["metric"] == "outside_error_px" and row["seed"] == 1)
    row["value"] += 1e-3
    file.write_bytes(lzma.compress("".join(json.dumps(each) + "\n" for each in rows).encode()))
    assert publish(tmp_path / "other", "--check") == 1
    assert "its committed rows are not those of its hash" in capsys.readouterr().out

    # With a hash that fits, only a run finds it.
    changed = table_files.read_rows_of("smoke")
    made = contents()
    made["rows"]["sha256"] = table_files.hash_of_figures(changed, made["rows"]["unrepeatable"])
    (ledger.TABLES_FOLDER / "smoke.json").write_text(json.dumps(made))
    assert publish(tmp_path / "other", "--check", "--episodes", "1") == 0
    capsys.readouterr()
    assert publish(tmp_path / "other", "--check") == 1
    assert f"smoke: {row['tracker']} has other figures on 1 seeds, first on 1" in capsys.readouterr().out
    file.unlink()
    assert publish(tmp_path / "other", "--check") == 1
    assert not (tmp_path / "other").exists()


def test_a_check_has_the_trackers_of_the_published_table(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    listed(replace(SMOKE, trackers=("hold",)))
    assert publish(tmp_path / "out") == 0
    assert contents()["trackers"] == ["hold"]
    # As if a tracker were registered since: the table's data name none.
    listed(replace(SMOKE, trackers=("hold", "constant_velocity")))
    assert publish(tmp_path / "out", "--check") == 0
    listed(replace(SMOKE, seeds=range(3)))
    assert publish(tmp_path / "out", "--check") == 2
    assert "tables: expected smoke as published" in capsys.readouterr().err


def test_a_check_of_all_takes_what_can_be_compared_and_names_the_rest(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert publish(tmp_path / "out") == 0
    made = contents()
    (ledger.TABLES_FOLDER / "fast.json").write_text(json.dumps({**made, "trackers": [], "rows": None}))
    fast = PublishedTable(name="fast", kind="speed", scenario=SMOKE.scenario, preset="quick", seeds=range(1))
    listed(fast, SMOKE, replace(SMOKE, name="later"))
    assert publish(tmp_path / "out", "--check") == 0
    printed = capsys.readouterr()
    assert "smoke: the same figures" in printed.out
    assert "note: not published, and not checked: later" in printed.err
    monkeypatch.setattr(BenchRun, "run", lambda *_: pytest.fail("ran before all were looked at"))
    for last in ("fast", "later"):
        assert publish(tmp_path / "out", "smoke", last, "--check") == 2
        assert last in capsys.readouterr().err


@pytest.mark.heavy
@pytest.mark.parametrize("has_them", [True, False])
def test_a_machine_with_other_instructions_is_told_that_figures_may_differ(
    has_them: bool, checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(tmp_path / "out") == 0
    monkeypatch.setattr("tools.publish.calculates_like_published", lambda _: has_them)
    assert publish(tmp_path / "out", "--check", "--episodes", "1") == 0
    assert ("note: figures may differ" in capsys.readouterr().err) == (not has_them)


@pytest.mark.heavy
def test_another_table_of_what_was_fitted_is_found(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def varied(figure: str) -> Callable[..., dict[str, Any]]:
        return lambda *_: {"words": "varied", "heads": ("what", "found"), "rows": (("threshold × 2", figure),)}

    monkeypatch.setattr(BenchRun, "varied", varied("0.7"))
    assert publish(tmp_path / "out") == 0
    assert contents()["varied"]["rows"] == [["threshold × 2", "0.7"]]
    assert publish(tmp_path / "other", "--check") == 0
    capsys.readouterr()
    monkeypatch.setattr(BenchRun, "varied", varied("0.6"))
    assert publish(tmp_path / "other", "--check") == 1
    assert "smoke: the table of what was fitted, varied, has other figures" in capsys.readouterr().out
