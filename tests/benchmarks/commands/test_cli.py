from __future__ import annotations

import errno
import json
import os
import re
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cli import main
from benchmarks.results import ledger
from benchmarks.run.records import read, read_blocks
from benchmarks.suites.frame_out.suite import FRAME_OUT
from benchmarks.suites.registry import Scene
from benchmarks.video.mp4 import Mp4Writer
from tests import fakes_scenario
from tests.benchmarks.no_room import no_room

FAKES = "fake_knowing,fake_still"


@pytest.fixture(autouse=True)
def _fake_suite(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let ``frameout bench frame-out`` run on the world of arithmetic."""
    name = fakes_scenario.FAKE_TOWN.id
    fake = replace(FRAME_OUT, scenes=(Scene(name, "frame-out"),), preset="tiny", quick_preset="tiny")
    monkeypatch.setattr("benchmarks.commands.bench.suite", lambda name: fake)


def bench(out: Path, *more: str) -> int:
    """Run a small bench in this process."""
    return main(["bench", "--workers", "0", "--seeds", "0:2", "--trackers", FAKES, "--out", str(out), *more])


def test_bench_prints_the_leaderboard_and_names_its_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bench(tmp_path) == 0
    out, _ = capsys.readouterr()
    lines = [line for line in out.splitlines() if "fake_" in line]
    assert [line.split()[0] for line in lines] == ["fake_knowing", "fake_still"]
    assert str(tmp_path / "report.html") in out
    assert (tmp_path / "report.html").is_file()


def test_json_is_all_that_stdout_holds(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert bench(tmp_path, "--json") == 0
    out, _ = capfd.readouterr()
    document = json.loads(out)
    assert document["summary"] == json.loads((tmp_path / "summary.json").read_text())
    assert document["failures"] == []


def test_a_run_to_be_published_is_in_the_ledger_when_it_is_through(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(ledger, "LEDGER", tmp_path / "ledger.jsonl")
    monkeypatch.setattr(ledger, "_commit", lambda: "0123456789")
    assert bench(tmp_path / "a", "--seeds", "10000:10001") == 0
    assert "--publish WHY" in capsys.readouterr().err
    assert ledger.published_runs() == {}
    assert bench(tmp_path / "b", "--seeds", "10000:10001", "--publish", "a table") == 0
    ((command, runs),) = ledger.published_runs().items()
    assert command == "frameout bench frame-out --trackers fake_knowing,fake_still --seeds 10000:10001"
    assert [run["why"] for run in runs] == ["a table"]


def test_a_tracker_that_fails_is_told_in_one_line_and_in_the_status(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench(tmp_path, "--trackers", "fake_raises", "fake_still", "fake_silent") == 1
    out, err = capsys.readouterr()
    told = [line for line in err.splitlines() if "fake_" in line]
    assert told[0].startswith("error: fake_raises failed in fake-town-v1 tiny, seed 0, frame 20: RuntimeError: a bug;")
    assert told[0].endswith("(and failed in 1 more)")
    assert "note: fake_silent said nothing (NaN) on 440 frames" in told[1]
    assert "Traceback" not in out + err


def test_report_is_made_again_from_rows_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    made = {name: (tmp_path / name).read_bytes() for name in ("summary.json", "comparisons.json", "report.html")}
    for name in made:
        (tmp_path / name).unlink()
    assert main(["report", str(tmp_path)]) == 0
    assert {name: (tmp_path / name).read_bytes() for name in made} == made
    assert capsys.readouterr().out.endswith(f"{tmp_path / 'report.html'}\n")


def test_report_and_compare_say_which_lines_they_ignore(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    rows = tmp_path / "records.jsonl"
    with rows.open("ab") as file:
        file.write(b'\xff\xfe\n{"suite": "frame-out", "scen')
    capsys.readouterr()
    told = f"note: ignored 2 lines of {rows}: 2 that are no rows, 0 of episodes that were cut off or made again later\n"
    assert main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().err == told
    assert main(["compare", *FAKES.split(","), "--directory", str(tmp_path)]) == 0
    assert capsys.readouterr().err == told
    assert rows.read_bytes().count(b"\xff") == 1


def test_rows_of_other_code_are_set_aside_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    rows = tmp_path / "records.jsonl"
    made = re.sub(r'"judge": "\w+"', '"judge": "another"', rows.read_text())
    rows.write_text(made)
    capsys.readouterr()
    assert bench(tmp_path) == 0
    aside = tmp_path / "records.outdated-1.jsonl"
    count = len(made.splitlines())
    assert f"note: {count} rows that are outdated, cut off or broken were moved to {aside}\n" in capsys.readouterr().err
    assert aside.read_text() == made


def test_a_full_disk_is_said_in_one_line_and_the_same_command_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    room = [True]

    def fsync(descriptor: int) -> None:
        if not room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        room.pop()

    with monkeypatch.context() as full:
        full.setattr(os, "fsync", fsync)
        assert bench(tmp_path) == 1
    errors = capsys.readouterr().err.splitlines()
    rows = tmp_path / "records.jsonl"
    assert [line for line in errors if "error" in line] == [
        f"error: {rows}: No space left on device; what was written before stands"
    ]
    assert "Traceback" not in "".join(errors)
    assert len(read_blocks(tmp_path)) == 1
    assert read(tmp_path).broken == read(tmp_path).replaced == []
    assert bench(tmp_path) == 0
    assert len(read_blocks(tmp_path)) == 4


_MISTAKES = {
    "role": (
        """
        from tests.fakes_scenario import Still
        from trackers.registry import register
        register("mine", role="our", summary="")(Still)
        """,
        4,
        "role: expected one of ours, .*; got 'our'",
    ),
    "controllers_role": (
        """
        from trackers.controllers.catalogue import register_controller
        from trackers.controllers.hold import HoldController
        register_controller("mine", role="our", carrier="helicopter", summary="")(HoldController)
        """,
        4,
        "role: expected one of ours, .*; got 'our'",
    ),
    "parameters": (
        """
        from trackers.registry import register
        @register("mine", role="external", summary="")
        class Mine: pass
        """,
        3,
        "Parameters: expected a dataclass of this name in class Mine, got none",
    ),
    "controllers_parameters": (
        """
        from trackers.controllers.catalogue import register_controller
        @register_controller("mine", role="ours", carrier="helicopter", summary="")
        class Mine: pass
        """,
        3,
        "Parameters: expected a dataclass of this name in class Mine, got none",
    ),
    "syntax": ("\n\ndef half(:\n", 3, "SyntaxError: invalid syntax"),
    "division": ("\nx = 1 / 0\n", 2, "ZeroDivisionError: division by zero"),
    "ends": ("import sys\nsys.exit('no arguments')\n", 2, "SystemExit: no arguments"),
}


@pytest.mark.parametrize("mistake", _MISTAKES)
def test_a_mistake_in_a_users_module_is_said_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, mistake: str
) -> None:
    """Before anything is run, and not when the whole run is over."""
    source, line, reason = _MISTAKES[mistake]
    file = tmp_path / f"with_a_mistake_{mistake}.py"
    file.write_text(textwrap.dedent(source))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert bench(tmp_path / "out", "--modules", file.stem) == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert error.startswith("error: modules: expected one that can be imported, got ")
    assert f", {file}, line {line}: " in error
    assert re.search(reason, error)
    assert not (tmp_path / "out").exists()


def test_report_prints_the_leaderboard_in_markdown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    capsys.readouterr()
    assert main(["report", str(tmp_path), "--markdown"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    head, rule, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    assert head[:3] == ["tracker", "role", "recovery rate (%) ↑"]
    assert all(set(cell) <= {"-", ":"} for cell in rule)
    assert [row[0] for row in rows] == ["`fake_knowing`", "`fake_still`"]
    summary = json.loads((tmp_path / "summary.json").read_text())
    for row in rows:
        entry = next(e for e in summary if e["metric"] == "recovery_rate" and e["tracker"] == row[0].strip("`"))
        percents = [100 * entry[key] for key in ("mean", "ci_low", "ci_high")]
        assert [float(number) for number in re.findall(r"[\d.]+", row[2])] == pytest.approx(percents, abs=0.05)


def test_compare_shows_differences_by_attribute(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(tmp_path)
    capsys.readouterr()
    assert main(["compare", "fake_knowing", "fake_still", "--directory", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    by_name = {(entry["frame_outs"], entry["metric"]): entry for entry in found}
    assert by_name["all", "recovered"]["difference"] == 1.0
    assert by_name["left by the left", "recovered"]["difference"] == 1.0
    assert ("off the road", "recovered") not in by_name
    assert all(entry["p_holm"] >= entry["p"] for entry in found)
    there = f"{tmp_path}:fake_knowing"
    assert main(["compare", there, there, "--json"]) == 0
    assert all(entry["difference"] == 0.0 for entry in json.loads(capsys.readouterr().out))
    assert main(["compare", "fake_knowing", "fake_still", "--directory", str(tmp_path)]) == 0
    assert "fake_knowing minus fake_still" in capsys.readouterr().out


def test_list_names_everything(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    for name in ("road-town-v1", "paper-a2", "standard", "colour_pf", "oracle_map", "centre", "frame-out"):
        assert name in out
    robot = out.split("controllers of the robot")[1]
    helicopter = out.split("controllers of the helicopter")[1].split("controllers of the robot")[0]
    for text in (helicopter, robot):
        assert re.search(r"\bhold +blind", text)
    assert main(["list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scenarios"][0]["scenario"] == "road-town-v1"


@pytest.mark.parametrize(
    "command", ["list", "bench", "compare", "paper", "render", "report", "speed", "tune", "learn-colours"]
)
def test_help_says_something_of_every_option(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    out = capsys.readouterr().out
    assert f"usage: frameout {command}" in out
    assert "{None}" not in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nix"], "command: expected one of list, bench, .*; got 'nix'"),
        (["bench", "--nix", "3"], "arguments: expected options of `frameout bench --help`, got '--nix'"),
        (["bench", "--workers", "two"], "workers: expected a whole number, got 'two'"),
        (["bench", "--workers", "-2"], "workers: expected a whole number >= 0, got -2"),
        (["bench", "--limit-s", "long"], "limit-s: expected a number, got 'long'"),
        (["bench", "--seeds", "5"], "seeds: expected A:B with 0 <= A < B, got '5'"),
        (["bench", "--seeds=-5:5"], "seeds: expected A:B with 0 <= A < B, got '-5:5'"),
        (["bench", "--seeds", "5:5"], "seeds: expected A:B with 0 <= A < B, got '5:5'"),
        (["bench", "--preset", "nix"], "presets: expected one of tiny, tiny-loop; got 'nix'"),
        (["bench", "--trackers", "nix"], "trackers: expected one of .*colour_pf.*; got 'nix'"),
        (["bench", "--controllers", "nix"], "controllers: expected one of set-path, .*; got 'nix'"),
        (["bench", "--renderer", "nix"], "renderer: expected one of raster, pybullet; got 'nix'"),
        (["bench", "--modules", "nix"], "modules: expected one that can be imported, got 'nix'"),
        (["bench", "--out", "/proc/nix"], "out: expected a folder that can be written, got '/proc/nix'"),
        (["report"], "directory: expected a value, got none"),
        (["report", "/nix"], "directory: expected one that holds records.jsonl, got '/nix'"),
        (["paper", "Z9"], "experiment: expected one of A2, A3, B1, B2, B3; got 'Z9'"),
        (["paper", "A2", "--renderer", "nix"], "renderer: expected one of raster, pybullet; got 'nix'"),
        (["render", "nix"], "scenario: expected one of road-town-v1.*; got 'nix'"),
        (["render", "--preset", "nix"], "preset: expected one of .*; got 'nix'"),
        (["render", "--seed", "-1"], "seed: expected a whole number >= 0, got -1"),
        (["render", "--seed", "x"], "seed: expected a whole number, got 'x'"),
        (["render", "--tracker", "nix"], "tracker: expected one of .*; got 'nix'"),
        (["render", "--scale", "0.5"], "scale: expected a number >= 1, got 0.5"),
        (["render", "--scale", "nan"], "scale: expected a number >= 1, got nan"),
        (
            ["render", "--scale", "200"],
            "scale: expected a larger view of at most 16,777,216 pixels, got 12,288,000,000",
        ),
        (["render", "--scale", "inf"], "scale: expected a larger view of at most 16,777,216 pixels, got inf"),
        (["render", "--out", "x.avi"], "out: expected a file that ends in .mp4, got 'x.avi'"),
        (["render", "--out", "folder.mp4"], "out: expected a file that ends in .mp4, got 'folder.mp4'"),
        (["render", "--out", "/proc/nix/x.mp4"], "out: expected a folder that can be written, got '/proc/nix'"),
        (
            ["tune", "colour_pf", "--seeds", "9999:10001"],
            "seeds: expected development seeds, below 10000, got '9999:10001'",
        ),
        (["tune", "opencv_mil"], "tracker: expected one with tunable parameters, got 'opencv_mil', which has none"),
        (["tune", "nix"], "tracker: expected one of .*; got 'nix'"),
        (["tune", "--trials", "0"], "trials: expected a whole number >= 1, got 0"),
        (
            ["learn-colours", "--seeds", "10000:10001"],
            "seeds: expected development seeds, below 10000, got '10000:10001'",
        ),
        (
            # The classes are the town's: no other scenario's colours may take their place.
            ["learn-colours", "--scenario", "stereo-follow"],
            "arguments: expected options of `frameout learn-colours --help`, got '--scenario'",
        ),
        (
            ["train", "--fit-model", "9999:10001"],
            "fit_model: expected development seeds, below 10000, got '9999:10001'",
        ),
        (["tune", "--controllers", "centre", "nix"], "controller: expected one of .*; got 'nix'"),
        (
            ["tune", "--controllers", "centre", "--preset", "quick", "hard"],
            "preset: expected one for .*, got quick hard",
        ),
        (
            ["train", "--fit-model", "1:2", "--check-model", "3:4"],
            "fit_model: expected it without check_model, got '1:2' with it",
        ),
        (
            ["train", "--pictures", "--starts", "frame-outs"],
            "starts: expected episodes with pictures, which begin on frame 0, got 'frame-outs'",
        ),
        (["tune", "--controllers", "centre_as_written"], "controllers: expected one that is used as tuned, got .*"),
        (["speed", "--frames", "7"], "frames: expected a whole number >= 8, got 7"),
        (["speed", "--soak", "7"], "soak: expected a whole number >= 1000, got 7"),
        (["compare", "a", "b", "--directory", "/nix"], "directory: expected one that holds records.jsonl, got '/nix'"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.mp4").mkdir()
    assert main(words) == 2
    out, err = capsys.readouterr()
    # A fresh install also says, once, that it compiles.
    (line,) = (line for line in err.splitlines() if not line.startswith("compiling kernels"))
    assert out == ""
    assert re.fullmatch(f"error: {message}.*", line), line


def test_without_optuna_tuning_names_the_command_that_installs_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    assert main(["tune", "colour_pf"]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error")]
    assert "pip install 'frameout[tune]'" in line


def test_a_fault_of_the_program_is_not_dressed_up_as_a_wrong_argument(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(directory: Path) -> None:
        raise ValueError("zip() argument 2 is longer than argument 1")

    monkeypatch.setattr("benchmarks.commands.report.write_summary", broken)
    with pytest.raises(ValueError, match="zip"):
        main(["report", "/nix"])


@pytest.mark.parametrize(
    ("words", "where", "goes_on"),
    [
        (["list"], "list_all.load_modules", False),
        (["render"], "render.render_episode", False),
        (["report", "/nix"], "report.write_summary", False),
        (["bench"], "bench.load_modules", True),
        (["paper", "A2"], "paper.seed_range", True),
        (["train"], "train.make_folder", True),
        (["tune"], "tune.make_folder", True),
    ],
)
def test_stopping_says_how_to_go_on_where_the_command_does(
    words: list[str],
    where: str,
    goes_on: bool,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(f"benchmarks.commands.{where}", stopped)
    assert main(words) == 130
    told = "stopped; the same command goes on from here\n" if goes_on else "stopped\n"
    assert capsys.readouterr().err == told


def test_a_video_that_finds_no_room_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def render(scenario: str, out: Path, **_: object) -> Path:
        pictures = np.random.default_rng(0).integers(0, 255, (30, 64, 64, 3), dtype=np.uint8)
        with no_room(1000), Mp4Writer(out, 15.0) as video:
            for picture in pictures:
                video.write(picture)
        return out

    monkeypatch.setattr("benchmarks.commands.render.render_episode", render)
    assert main(["render", "--out", str(tmp_path / "x.mp4")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(r"error: .*x\.mp4.*: File too large; what was written before stands\n", err)
    assert list(tmp_path.iterdir()) == []


def test_no_command_shows_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "frameout bench frame-out --quick" in capsys.readouterr().out
    assert main(["--help"]) == 0
