"""One command makes a published table and writes its files; what is current is not made again."""

from __future__ import annotations

import dataclasses
import json
import lzma
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract.rows import FILE_NAME, read_blocks
from benchmarks.papers import experiment
from benchmarks.papers.b1 import DimmedLamp
from scenarios.scenario import RendererName
from tests.tools.command import tools
from tests.tools.publishing.conftest import SMOKE, commit_all, contents, git, publish, recorded
from tools.publishing import ledger, table_files, tables
from tools.publishing.tables import BenchTable, PaperTable, SpeedTable
from trackers import registry

pytestmark = pytest.mark.usefixtures("smoke")
Listed = Callable[..., None]
Captured = pytest.CaptureFixture[str]


def test_the_files_of_a_table_hold_how_it_was_made(checkout: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert publish(out) == 0
    made = contents()
    command = "frameout bench belt --scenario conveyor-v1 --preset quick --trackers hold constant_velocity --seeds 0:2"
    assert made["command"] == command
    assert made["commit"] == git(checkout, "rev-parse", "--short=10", "HEAD")
    assert made["seeds"] == "0:2"
    assert made["summary"] == json.loads((out / "smoke/summary.json").read_text())
    assert {entry["tracker"] for entry in made["summary"]} == {"hold", "constant_velocity"}
    assert set(made["editions"]["contestants"]) == {"hold", "constant_velocity"}
    assert {"numpy", "judge"} <= set(made["editions"]["shared"])
    assert made["editions"]["scenes"]["quick"].startswith("conveyor-v1 ")
    rows = lzma.decompress((ledger.TABLES_FOLDER / "smoke.jsonl.xz").read_bytes())
    assert rows == (out / "smoke" / FILE_NAME).read_bytes()
    assert made["rows"]["count"] == len(rows.splitlines())
    assert str(tmp_path) not in json.dumps(made)


def test_a_table_of_two_presets_names_both_scenes_and_no_preset_has_two() -> None:
    def block(preset: str, scene: str) -> list[dict[str, Any]]:
        editions = {"scene": scene, "judge": "belt 1", "tracker": "hold 1"}
        return [{"preset": preset, "tracker": "hold", "controller": None, "editions": editions}]

    one, other = block("uniform", "conveyor-v1 aa"), block("dressed-apart", "conveyor-v1 bb")
    made = table_files.editions_of_rows({1: one, 2: other})
    assert made["scenes"] == {"uniform": "conveyor-v1 aa", "dressed-apart": "conveyor-v1 bb"}
    wrong = "rows of one edition of the scene of preset uniform, got conveyor-v1 aa, conveyor-v1 bb"
    with pytest.raises(ValueError, match=wrong):
        table_files.editions_of_rows({1: one, 2: block("uniform", "conveyor-v1 bb")})


def test_a_stopped_run_keeps_what_was_made_and_goes_on(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    out = tmp_path / "out"
    run = BenchTable.make

    def stopped(self: BenchTable, folder: Path, workers: int, progress: Callable[[int, int], None]) -> None:
        def report(done: int, of: int) -> None:
            if done == 2:
                raise KeyboardInterrupt

        run(self, folder, workers, report)

    monkeypatch.setattr(BenchTable, "make", stopped)
    assert publish(out) == 130
    assert "the same command continues" in capsys.readouterr().err
    kept = read_blocks(out / "smoke")
    assert {key.seed for key in kept} == {0}
    assert not ledger.TABLES_FOLDER.exists()
    monkeypatch.setattr(BenchTable, "make", run)
    before = {key: rows[0]["seconds"] for key, rows in kept.items()}
    assert publish(out) == 0
    after = read_blocks(out / "smoke")
    assert {key.seed for key in after} == {0, 1}
    assert {key: after[key][0]["seconds"] for key in before} == before


def test_only_code_as_committed_is_published(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    (checkout / "benchmarks/module.py").write_text("changed = True\n")
    assert publish(tmp_path / "out") == 2
    assert "publish: expected committed code, got changes in benchmarks/module.py" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    git(checkout, "checkout", "--quiet", ".")
    (checkout / "benchmarks/new.json").touch()
    assert publish(tmp_path / "out") == 2
    assert "got changes in benchmarks/new.json" in capsys.readouterr().err
    assert publish(tmp_path / "out", "--dry-run") == 0
    assert " ".join(("smoke", "0:2", "frameout bench belt")) in " ".join(capsys.readouterr().out.split())
    (checkout / "benchmarks/new.json").unlink()
    monkeypatch.setattr(BenchTable, "make", lambda *_: commit_all(checkout, "meanwhile"))
    assert publish(tmp_path / "out") == 2
    assert "of the start until the end" in capsys.readouterr().err
    assert not ledger.TABLES_FOLDER.exists()


def test_outside_a_checkout_nothing_is_published(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    """Installed somewhere within another repository, too, which does not hold the ledger."""
    git(tmp_path, "init", "--quiet")
    monkeypatch.setattr(ledger, "LEDGER", tmp_path / "test_split_runs.jsonl")
    assert publish(tmp_path / "out") == 2
    assert "publish: expected a checkout" in capsys.readouterr().err


@pytest.mark.heavy
def test_rows_of_an_earlier_commit_of_the_present_editions_stay(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    first = git(checkout, "rev-parse", "--short=10", "HEAD")
    assert publish(out) == 0
    # What publishing wrote does not count as a change.
    assert publish(out) == 0
    assert contents()["commit"] == first
    before = read_blocks(out / "smoke")
    # One tracker's parameters are others now: its rows alone are made anew.
    changed = dataclasses.replace(registry.entry("constant_velocity"), overrides={"acceleration_px": 2.5})
    monkeypatch.setitem(registry._ENTRIES, "constant_velocity", changed)
    second = commit_all(checkout, "second")
    assert publish(out) == 0
    assert contents()["commit"] == second
    after = read_blocks(out / "smoke")
    assert after.keys() == before.keys()
    for key, rows in after.items():
        assert (rows == before[key]) == (key.tracker != "constant_velocity")


def test_rows_of_trackers_and_seeds_that_a_table_lost_go(checkout: Path, tmp_path: Path, listed: Listed) -> None:
    out = tmp_path / "out"
    assert publish(out) == 0
    listed(replace(SMOKE, trackers=("hold",), seeds=range(1, 3)))
    commit_all(checkout, "second")
    assert publish(out) == 0
    assert {(key.tracker, key.seed) for key in read_blocks(out / "smoke")} == {("hold", 1), ("hold", 2)}
    assert {entry["tracker"] for entry in contents()["summary"]} == {"hold"}
    assert list((out / "smoke").glob("records.outdated-*"))


@pytest.mark.heavy
def test_a_run_on_the_test_split_that_makes_rows_is_recorded_and_a_new_folder_begins_with_the_committed_ones(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: Listed
) -> None:
    assert publish(tmp_path / "out") == 0
    assert recorded() == []
    monkeypatch.setattr(ledger, "TEST_SPLIT", range(2, 4))
    listed(replace(SMOKE, seeds=range(2, 3)))
    first = git(checkout, "rev-parse", "--short=10", "HEAD")
    assert publish(tmp_path / "test") == 0
    (entry,) = recorded()
    assert entry["command"].endswith("--seeds 2:3")
    assert (entry["commit"], entry["split"], entry["seeds"]) == (first, "test", "2:3")
    assert entry["why"] == "table smoke"
    commit_all(checkout, "second")
    assert publish(tmp_path / "another") == 0
    kept, begun = (read_blocks(tmp_path / name / "smoke") for name in ("test", "another"))
    assert {key: rows[0]["seconds"] for key, rows in kept.items()} == {
        key: rows[0]["seconds"] for key, rows in begun.items()
    }
    assert recorded() == [entry], "nothing was made"
    (ledger.TABLES_FOLDER / "smoke.jsonl.xz").unlink()
    for _ in range(2):
        assert publish(tmp_path / "anew") == 0
    assert len(recorded()) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--dry-run", "--check"], "publish: expected one of --dry-run, --check, --render"),
        (["nothing"], "tables: expected some of smoke, got 'nothing'"),
        (["--episodes", "2"], "episodes: expected a whole number >= 1, with --check alone, got 2"),
        (["smoke", "--check"], "tables: expected some that were published with rows, as times are never equal, got"),
        (["--check"], "tables: expected some that were published with rows, as times are never equal, got smoke"),
    ],
)
def test_wrong_words_are_named(
    words: list[str], message: str, checkout: Path, tmp_path: Path, capsys: Captured
) -> None:
    assert publish(tmp_path / "out", *words) == 2
    assert message in capsys.readouterr().err


class QuickSheet(DimmedLamp):
    """Paper B1 whose measurements are typed in."""

    def measure(self, seed: int, renderer: RendererName) -> dict[str, float]:
        """See ``CameraExperiment``."""
        return {claim.metric: 0.01 * seed for claim in self.claims} | {"frames": 9.0}

    def sensitivity(self, *of: object) -> None:
        """See ``PaperExperiment``: nothing is varied."""


def test_a_paper_is_published_with_its_claims(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: Listed, capsys: Captured
) -> None:
    b1 = experiment.experiment_named("B1")
    fields = {field.name: getattr(b1, field.name) for field in dataclasses.fields(b1)}
    monkeypatch.setattr(tables, "experiment_named", lambda name: QuickSheet(**fields))
    listed(PaperTable(name="sheet", experiment="B1", seeds=range(3, 5)))
    assert publish(tmp_path / "out") == 0
    made = contents("sheet")
    assert made["command"] == "frameout paper B1 --seeds 3:5"
    assert {found["metric"] for found in made["findings"]} == {claim.metric for claim in b1.claims}
    assert {found["mean"] for found in made["findings"]} == {0.035}
    assert [entry["mean"] for entry in made["summary"]] == [found["mean"] for found in made["findings"]]
    assert publish(tmp_path / "out", "--check") == 0
    assert "sheet: the same figures on seeds 3:5" in capsys.readouterr().out
    ledger.TEMPLATE.write_text("{{ paper('sheet') }}\n")
    assert tools(["publish", "--render"]) == 0
    page = ledger.RESULTS.read_text()
    assert page.count(": yes |") == sum(found["agrees"] is True for found in made["findings"])
    assert page.count(": no |") == sum(found["agrees"] is False for found in made["findings"]) > 0


def test_a_speed_is_published_without_rows_and_always_measured_anew(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: Listed, capsys: Captured
) -> None:
    entry = {
        "scenario": SMOKE.scenario,
        "preset": "quick",
        "tracker": "raster",
        "metric": "frames_per_s",
        "unit": "1/s",
    }
    entry |= {"mean": 61.25, "ci_low": 58.0, "ci_high": 64.0}
    monkeypatch.setattr("tools.time_speed.measure_rendering", lambda *_: {})
    monkeypatch.setattr("tools.time_speed.entries_of", lambda *_: [entry])
    listed(SpeedTable(name="fast", scenario=SMOKE.scenario, preset="quick", seeds=range(1)))
    assert publish(tmp_path / "out") == 0
    made = contents("fast")
    assert (made["rows"], made["summary"]) == (None, [entry])
    ledger.TEMPLATE.write_text("{{ value('fast', 'raster', 'frames_per_s') }}\n")
    assert tools(["publish", "--render"]) == 0
    assert ledger.RESULTS.read_text() == "61.2 (58.0–64.0)\n"
    assert publish(tmp_path / "out", "fast", "--check") == 2
    assert "as times are never equal, got fast" in capsys.readouterr().err
    entry["mean"] = 60.5
    assert publish(tmp_path / "out") == 0
    assert contents("fast")["summary"][0]["mean"] == 60.5
