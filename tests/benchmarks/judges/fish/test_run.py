"""The suite ``fish`` from the command line: an episode, and files of real tracks."""

from __future__ import annotations

import json
import shlex
import weakref
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.cli.bench_function import bench as python_bench
from benchmarks.cli.main import main
from benchmarks.contract.suite import suite
from benchmarks.contract.track_table import TrackTable
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.outcome import TrackerWarning
from benchmarks.run.process_state import ProcessState
from benchmarks.show.results import Results
from tests.benchmarks.data.written_tracks import write_tracks
from tests.benchmarks.judges.fish.fake_trackers import Holds, HoldsAlone
from tests.benchmarks.judges.fish.gap_methods import swimming

FAKES = "tests.benchmarks.judges.fish.fake_trackers"


def bench(out: Path, *words: str, trackers: Sequence[str] = ("fake_nearest", "fake_holds")) -> int:
    given = ["bench", "fish", "--modules", FAKES, "--trackers", *trackers, "--out", str(out), "--workers", "0"]
    return main([*given, *words])


def rows_of(out: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]


@pytest.fixture(scope="module")
def episode(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("fish")
    assert bench(out, "--preset", "few", "--seeds", "3:4") == 0
    return out


@pytest.mark.heavy
def test_rows_are_defined_and_summed_up(episode: Path) -> None:
    rows = rows_of(episode)
    by_tracker = {
        name: {row["metric"] for row in rows if row["tracker"] == name} for name in ("fake_nearest", "fake_holds")
    }
    assert {"hota", "hota_at_once", "mota", "identity_right_frames", "frames_per_s"} <= by_tracker["fake_nearest"]
    for names in by_tracker.values():
        # An episode of 200 frames has no room for a gap of 50 with 100 frames before and after it.
        assert {"gap_error_50_px", "gap_coverage_50"} <= names
    assert not {"hota", "link_made", *TIMES} & by_tracker["fake_holds"]
    made = {each.name for metric in suite("fish").metrics for each in metric.statistic.of}
    drawn = ("identity_runs_", "gap_runs_", "motion_", "gap_error_by_frame_px", "link_made", "link_right", "frames")
    assert not [name for name in by_tracker["fake_nearest"] - made if not name.startswith(drawn)]


@pytest.mark.heavy
def test_the_same_method_has_the_same_errors_in_a_chain_and_alone(episode: Path) -> None:
    values: dict[str, dict[str, float]] = {}
    for row in rows_of(episode):
        if row["metric"].startswith("gap_"):
            values.setdefault(row["tracker"], {})[row["metric"]] = row["value"]
    gaps = {name: {k: v for k, v in each.items() if not k.startswith("gap_runs")} for name, each in values.items()}
    assert gaps["fake_holds"] == gaps["fake_nearest"]


@pytest.mark.heavy
def test_hindsight_that_renames_all_changes_no_score(episode: Path) -> None:
    values = {row["metric"]: row["value"] for row in rows_of(episode) if row["tracker"] == "fake_nearest"}
    for name in ("hota", "mota", "identity_right_frames", "identity_switches"):
        assert values[name] == values[f"{name}_at_once"]


def test_the_report_says_how_the_fish_swim(episode: Path) -> None:
    page = (episode / "report.html").read_text()
    for words in ("How they swim", "straightness"):
        assert words in page, words
    # Gaps of 200 frames have no room.
    assert "How far off is a lost fish?" not in page


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Path]]:
    folder = tmp_path_factory.mktemp("files")
    position = swimming(1200, 3)
    position[400:420, 0] = np.nan
    position[700:730, 1] = np.nan
    table = TrackTable("pond", position, ("0", "1", "2"), 25.0)
    lake = write_tracks(replace(table, name="lake"), folder, "trex")
    return folder, [*write_tracks(table, folder, "idtracker"), *lake]


@pytest.mark.heavy
def test_real_tracks_have_gaps_and_links(files: tuple[Path, list[Path]], capsys: pytest.CaptureFixture[str]) -> None:
    folder, paths = files
    assert bench(folder / "out", "--real", *map(str, paths)) == 0
    told = capsys.readouterr()
    assert "pond; it tells no frame rate, 30 a second are taken" in told.err
    assert "lake; places in cm are scaled to 600 px from the leftmost to the rightmost" in told.err
    assert "blocks of time" in told.out
    rows = rows_of(folder / "out")
    assert {(row["scenario"], row["preset"], row["renderer"]) for row in rows} == {
        ("real", "lake", "real"),
        ("real", "pond", "real"),
    }
    assert {row["seed"] for row in rows} == {0, 1, 2}
    # Both files hold the same tracks, but for the unit; the first one's errors are in its own pixels.
    known_px = swimming(1200, 3)[..., 0]
    errors_px = {
        name: [row["value"] for row in rows if row["preset"] == name and row["metric"] == "gap_error_50_px"]
        for name in ("pond", "lake")
    }
    assert errors_px["lake"] == pytest.approx(np.array(errors_px["pond"]) * 600.0 / np.ptp(known_px), rel=1e-3)
    links = [row for row in rows if row["metric"] == "link_made" and row["tracker"] == "fake_holds"]
    links = [row for row in links if row["preset"] == "pond"]
    assert [(row["event"]["fish"], row["event"]["length_frames"]) for row in links] == [(0, 20), (1, 30)]
    page = (folder / "out" / "report.html").read_text()
    assert "real recording, blocks of time" in page
    assert f"frameout bench fish --real {shlex.join(map(str, paths))} --trackers " in page


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--real", "x", "--preset", "quick"], "preset: expected none with --real, which runs no episodes, got"),
        (["--real", "x", "--seeds", "0:3"], "seeds: expected none with --real, which runs no episodes, got range"),
        (["--real", "x", "--renderer", "pybullet"], "renderer: expected raster with --real"),
        (["--real", "x", "--link", "noisy"], "link: expected prompt, since suite fish knows no other"),
    ],
)
def test_wrong_arguments_are_named(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench(tmp_path, *words) == 2
    assert message in capsys.readouterr().err


def test_trackers_without_gaps_and_a_file_given_twice_are_refused(
    files: tuple[Path, list[Path]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    real = ["--real", str(files[1][0]), "--out", str(tmp_path), "--workers", "0"]
    assert bench(tmp_path, "--real", str(files[1][0]), str(files[1][0])) == 2
    assert "real: expected different files, got pond.txt twice" in capsys.readouterr().err
    assert main(["bench", "fish", "--trackers", "hold", *real]) == 2
    assert "trackers: expected some with a gap method, got hold" in capsys.readouterr().err
    assert bench(tmp_path / "beside", *real[:2], trackers=("fake_holds", "hold")) == 0
    assert capsys.readouterr().err.count("note: hold has no gap_method and so no row, in 1 episode\n") == 1
    assert {row["tracker"] for row in rows_of(tmp_path / "beside")} == {"fake_holds"}
    assert bench(tmp_path, "--real", str(files[1][0]), "--keep-estimates") == 2
    assert "keep_estimates: expected none with tracks, on which no frame is judged" in capsys.readouterr().err


def on_real(out: Path, *paths: Path, trackers: Sequence[str] = ("fake_holds",), workers: int = 0) -> Results:
    return python_bench("fish", real=paths, trackers=trackers, modules=FAKES, out=out, workers=workers)


@pytest.fixture
def short_files(tmp_path: Path) -> dict[str, Path]:
    """Files of one animal of 160 frames, of two sessions with the same name, one too short, and one that is broken."""
    table = TrackTable("trajectories", swimming(160, 1), ("0",), 30.0)
    paths = {name: write_tracks(table, tmp_path / name, "idtracker.ai")[0] for name in ("monday", "tuesday")}
    (paths["short"],) = write_tracks(replace(table, name="short", position=table.position[:20]), tmp_path, "idtracker")
    paths["broken"] = tmp_path / "broken.csv"
    paths["broken"].write_text("x1,y1\nleft,2\n")
    return paths


def test_what_cannot_be_used_is_named_and_the_rest_is_scored_once(short_files: dict[str, Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    for resumed in (0, 2):
        with pytest.warns(TrackerWarning, match=r"broken.csv|short"):
            outcome = on_real(out, *short_files.values()).outcome
        assert outcome.unusable == [
            "broken.csv: expected numbers in x1, y1, frame, got others: could not convert string to float: 'left'",
            "short: expected tracks that are long enough for gaps, got none that is",
        ]
        assert (outcome.resumed, outcome.moved) == (resumed, [])
    rows = rows_of(out)
    assert {row["preset"] for row in rows} == {"monday-trajectories", "tuesday-trajectories"}
    assert {(row["seed"], row["blocks"]) for row in rows} == {(0, 1)}
    # Another file of the same name is another recording.
    write_tracks(TrackTable("trajectories", swimming(170, 1), ("0",), 30.0), tmp_path / "monday", "idtracker.ai")
    again = on_real(out, short_files["monday"], short_files["tuesday"]).outcome
    assert (again.resumed, again.episodes, len(again.moved)) == (1, 1, 1)


def test_files_that_are_all_too_short_have_no_rows(short_files: dict[str, Path], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^short: expected tracks that are long enough for gaps, got none that is$"):
        on_real(tmp_path / "out", short_files["short"])


def test_a_recording_that_a_stopped_run_left_in_part_is_run_again(tmp_path: Path) -> None:
    (path,) = write_tracks(TrackTable("pond", swimming(700, 1), ("0",), 30.0), tmp_path, "idtracker")
    on_real(tmp_path / "out", path)
    whole = rows_of(tmp_path / "out")
    assert {row["blocks"] for row in whole} == {2}
    file = tmp_path / "out" / "records.jsonl"
    file.write_text("".join(json.dumps(row) + "\n" for row in whole if row["seed"] == 0))
    assert on_real(tmp_path / "out", path).outcome.episodes == 1
    again = rows_of(tmp_path / "out")
    assert [row | {"seconds": 0} for row in again] == [row | {"seconds": 0} for row in whole]


def test_a_gap_method_is_dropped_before_what_it_has_left_is_looked_for(
    short_files: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else processes that end with it are told as left."""
    methods: list[weakref.ref[Holds]] = []
    left: list[int] = []

    def init(self: HoldsAlone, *given: object) -> None:
        self.gap_method = Holds()
        methods.append(weakref.ref(self.gap_method))

    def close(self: ProcessState) -> list[str]:
        left.append(sum(each() is not None for each in methods))
        return []

    monkeypatch.setattr(HoldsAlone, "__init__", init)
    monkeypatch.setattr(ProcessState, "close", close)
    on_real(tmp_path / "out", short_files["monday"])
    assert (len(methods), left) == (1, [0])


@pytest.mark.heavy
def test_a_gap_method_that_ends_its_process_costs_its_own_rows(short_files: dict[str, Path], tmp_path: Path) -> None:
    path = short_files["monday"]
    with pytest.warns(TrackerWarning, match="fake_dies failed in real trajectories: ended its"):
        on_real(tmp_path / "both", path, trackers=("fake_dies", "fake_holds"), workers=1)
    on_real(tmp_path / "one", path, workers=1)
    beside = [row | {"seconds": 0} for row in rows_of(tmp_path / "both") if row["tracker"] == "fake_holds"]
    assert beside == [row | {"seconds": 0} for row in rows_of(tmp_path / "one")]
    with pytest.warns(TrackerWarning, match=r"\(in an earlier run, whose rows are kept"):
        assert on_real(tmp_path / "both", path, trackers=["fake_dies"], workers=1).outcome.episodes == 0
