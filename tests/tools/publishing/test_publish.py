"""One command makes a published table, writes its files, and makes it again with the same figures."""

from __future__ import annotations

import dataclasses
import json
import lzma
import re
import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.contract.rows import FILE_NAME, read_blocks
from benchmarks.papers import b1
from benchmarks.run import episode_time
from scenarios.scenario import RendererName
from tests.plain_scene import belt
from tests.tools.command import tools
from tests.tools.publishing.conftest import SMOKE, commit_all, contents, git, publish
from tools.publishing import ledger, table_files
from tools.publishing.published import PublishedTable
from tools.publishing.table_runs import BenchRun
from trackers.baselines.csrt_pipe import MAKE_IT, PYTHON_VARIABLE

pytestmark = pytest.mark.usefixtures("smoke", "unmeasured")
MEASURE = BenchRun.seconds_of_seed


def test_the_files_of_a_table_say_how_it_was_made(checkout: Path, tmp_path: Path) -> None:
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
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    run = BenchRun.run

    def stopped(self: BenchRun, folder: Path, workers: int, progress: Callable[[int, int], None]) -> None:
        def report(done: int, of: int) -> None:
            if done == 2:
                raise KeyboardInterrupt

        run(self, folder, workers, report)

    monkeypatch.setattr(BenchRun, "run", stopped)
    assert publish(out) == 130
    assert "the same command continues" in capsys.readouterr().err
    kept = read_blocks(out / "smoke")
    assert {key.seed for key in kept} == {0}
    assert not ledger.TABLES_FOLDER.exists()
    monkeypatch.setattr(BenchRun, "run", run)
    before = {key: rows[0]["seconds"] for key, rows in kept.items()}
    assert publish(out) == 0
    after = read_blocks(out / "smoke")
    assert {key.seed for key in after} == {0, 1}
    assert {key: after[key][0]["seconds"] for key in before} == before


def test_only_code_as_committed_is_published(
    checkout: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
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


def test_a_folder_that_publishing_did_not_make_is_refused(
    checkout: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "foreign/smoke").mkdir(parents=True)
    (tmp_path / "foreign/smoke" / FILE_NAME).touch()
    assert publish(tmp_path / "foreign") == 2
    assert "out: expected folders of tables that this command made" in capsys.readouterr().err


def test_a_checkout_that_changes_during_the_run_is_not_published(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(BenchRun, "run", lambda *_: commit_all(checkout, "meanwhile"))
    assert publish(tmp_path / "out") == 2
    assert "of the start until the end" in capsys.readouterr().err
    assert not ledger.TABLES_FOLDER.exists()


@pytest.mark.heavy
def test_more_rows_than_there_is_room_for_are_refused(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert publish(tmp_path / "out") == 0
    capsys.readouterr()
    size = (ledger.TABLES_FOLDER / "smoke.jsonl.xz").stat().st_size
    monkeypatch.setattr(table_files, "ROOM_BYTES", size + size // 2)
    # Its own rows of before do not count, those of other tables do.
    assert publish(tmp_path / "out") == 0
    second = replace(SMOKE, name="second")
    listed(SMOKE, second)
    assert publish(tmp_path / "out", "second") == 2
    assert "publish: expected compressed rows of all tables in " in capsys.readouterr().err
    assert not (ledger.TABLES_FOLDER / "second.json").exists()


@pytest.mark.heavy
def test_runs_on_the_test_split_are_in_the_ledger(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: Callable[..., None]
) -> None:
    assert publish(tmp_path / "out") == 0
    assert ledger.published_runs() == {}
    monkeypatch.setattr(ledger, "TEST_SPLIT", range(2, 4))
    listed(replace(SMOKE, seeds=range(2, 3)))
    assert publish(tmp_path / "test") == 0
    assert publish(tmp_path / "test") == 0
    ((command, runs),) = ledger.published_runs().items()
    assert command.endswith("--seeds 2:3")
    assert [run["why"] for run in runs] == ["table smoke"]
    commit_all(checkout, "second")
    assert publish(tmp_path / "test") == 0
    assert ledger.published_runs()[command] == runs
    (ledger.TABLES_FOLDER / "smoke.jsonl.xz").unlink()
    assert publish(tmp_path / "anew") == 0
    assert len(ledger.published_runs()[command]) == 2


def test_the_plan_names_tables_seeds_and_hours(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Measured once, then remembered; with rows of three seeds, by these."""
    out = tmp_path / "out"
    monkeypatch.setattr(BenchRun, "seconds_of_seed", lambda *_: 5400.0)
    assert publish(out, "--dry-run") == 0
    (line,) = [line.split() for line in capsys.readouterr().out.splitlines() if "smoke" in line]
    assert line[:4] == ["smoke", "0:2", "2", "3.00"]
    monkeypatch.setattr(BenchRun, "seconds_of_seed", lambda *_: pytest.fail("measured again"))
    assert publish(out, "--dry-run") == 0
    assert not (out / "smoke").exists()


def test_a_measurement_is_the_time_of_all_frames(smoke: PublishedTable, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every frame takes a second."""
    taken = []
    take_in = episode_time.take_in
    monkeypatch.setattr(episode_time, "take_in", lambda *of: (taken.append(1), take_in(*of)))
    monkeypatch.setattr(episode_time, "time", SimpleNamespace(process_time=lambda: float(len(taken))))
    told = []
    seconds = MEASURE(BenchRun(smoke), lambda done, of: told.append((done, of)))
    with closing(belt.CONVEYOR.episode("quick", 0)) as episode:
        frame_count = episode.frame_count
    assert seconds == 1.0 + frame_count
    assert told == [(0, 1), (1, 1)]


def test_a_tracker_that_is_not_installed_is_named_before_anything_runs(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv(PYTHON_VARIABLE, str(tmp_path / "none"))
    table = PublishedTable(name="town", suite="frame-out", scenario="road-town-v2", seeds=range(1))
    without = BenchRun(table).command
    assert " opencv_csrt " in without
    listed(SMOKE, table)
    assert publish(tmp_path / "out") == 2
    error = capsys.readouterr().err
    assert "tables: expected ones whose trackers are installed, got town: opencv_csrt: " in error
    assert MAKE_IT in error
    assert not (tmp_path / "out").exists()
    # A plan shows it beside the others.
    assert publish(tmp_path / "out", "--dry-run") == 0
    assert re.search(r"town .*not installed: opencv_csrt", capsys.readouterr().out)
    monkeypatch.setenv(PYTHON_VARIABLE, sys.executable)
    assert BenchRun(table).command == without


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--dry-run", "--check"], "publish: expected one of --dry-run, --check, --render"),
        (["nothing"], "tables: expected some of smoke, got 'nothing'"),
        (["--episodes", "2"], "episodes: expected a whole number >= 1, with --check alone, got 2"),
        (["smoke", "--check"], "tables: expected some that were published, got smoke"),
        (["--check"], "tables: expected some that were published with rows, got none"),
    ],
)
def test_wrong_words_are_named(
    words: list[str], message: str, checkout: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(tmp_path / "out", *words) == 2
    assert message in capsys.readouterr().err


class QuickSheet(type(b1.EXPERIMENT)):  # type: ignore[misc]
    """Paper B1 whose measurements are typed in."""

    def measure(self, seed: int, renderer: RendererName) -> dict[str, float]:
        """See ``CameraExperiment``."""
        return {claim.metric: 0.01 * seed for claim in self.claims} | {"frames": 9.0}

    def sensitivity(self, *of: object) -> None:
        """See ``PaperExperiment``: nothing is varied."""


def test_a_paper_is_published_with_its_claims(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    fields = {field.name: getattr(b1.EXPERIMENT, field.name) for field in dataclasses.fields(b1.EXPERIMENT)}
    monkeypatch.setattr(b1, "EXPERIMENT", QuickSheet(**fields))
    listed(PublishedTable(name="sheet", kind="paper", experiment="B1", seeds=range(3, 5)))
    assert publish(tmp_path / "out") == 0
    made = json.loads((ledger.TABLES_FOLDER / "sheet.json").read_text())
    assert made["command"] == "frameout paper B1 --seeds 3:5"
    assert {found["metric"] for found in made["findings"]} == {claim.metric for claim in b1.EXPERIMENT.claims}
    assert {found["mean"] for found in made["findings"]} == {0.035}
    assert [entry["mean"] for entry in made["summary"]] == [found["mean"] for found in made["findings"]]
    assert publish(tmp_path / "out", "--check") == 0
    assert "sheet: the same figures on seeds 3:5" in capsys.readouterr().out
    ledger.TEMPLATE.write_text("{{ paper('sheet') }}\n")
    assert tools(["publish", "--render"]) == 0
    page = ledger.RESULTS.read_text()
    assert page.count(": yes |") == sum(found["agrees"] is True for found in made["findings"])
    assert page.count(": no |") == sum(found["agrees"] is False for found in made["findings"]) > 0


def test_a_speed_is_published_without_rows(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    entry = {"scenario": SMOKE.scenario, "preset": "quick", "metric": "frames_per_s", "unit": "1/s"}
    entry |= {"mean": 61.25, "ci_low": 58.0, "ci_high": 64.0}
    monkeypatch.setattr("tools.time_speed.measure_scenario", lambda *_: [entry])
    listed(PublishedTable(name="fast", kind="speed", scenario=SMOKE.scenario, preset="quick", seeds=range(1)))
    assert publish(tmp_path / "out") == 0
    assert "about 0.00 h and those not known (?)" in capsys.readouterr().out
    made = json.loads((ledger.TABLES_FOLDER / "fast.json").read_text())
    assert (made["rows"], made["summary"]) == (None, [entry])
    ledger.TEMPLATE.write_text("{{ figures('fast') }}\n")
    assert tools(["publish", "--render"]) == 0
    assert "| frames per s | /s | 61.2 (58.0–64.0) |" in ledger.RESULTS.read_text()
    assert publish(tmp_path / "out", "fast", "--check") == 2
    assert "tables: expected some with rows, as times are never equal, got 'fast'" in capsys.readouterr().err
    commit_all(checkout, "second")
    monkeypatch.setattr("tools.time_speed.measure_scenario", lambda *_: [{**entry, "mean": 60.5}])
    assert publish(tmp_path / "out") == 0
    assert json.loads((ledger.TABLES_FOLDER / "fast.json").read_text())["summary"][0]["mean"] == 60.5
