"""Wrong arguments, interruptions and missing parts are reported in one line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cli import main as cli
from benchmarks.cli.main import main
from benchmarks.show.video.episode_video import write_mp4
from tests.benchmarks.no_room import no_room

pytestmark = pytest.mark.usefixtures("fake_suite")


@pytest.mark.parametrize("command", cli.FRAMEOUT.commands)
def test_help_says_something_of_every_option(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    out = capsys.readouterr().out
    assert f"usage: frameout {command}" in out
    assert "{None}" not in out
    assert "``" not in out
    assert max(len(line) for line in out.splitlines() if not line.startswith("usage: ")) <= 80
    assert re.search(r"│ [A-Z_]+ +[a-z_]+ \(required\)", out) is None
    said = " ".join(re.sub(r"[│╭╮╰╯─]", " ", out).split())
    # A default is said once, in words where it is none.
    assert re.search(r"\(default: (None|''|)\)|\(default: [^)]*\)\.? \(default", said) is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nix"], "command: expected one of list, bench, .*; got 'nix'"),
        (["bench", "--workers", "-2"], "workers: expected a whole number >= 0, got -2"),
        (["bench", "--preset", "nix"], "preset: expected one of tiny, tiny-loop.*; got 'nix'"),
        (["bench", "--trackers", "nix"], "trackers: expected one of .*colour_pf.*; got 'nix'"),
        (["bench", "--controllers", "nix"], "controllers: expected one of set-path, .*; got 'nix'"),
        (["bench", "--modules", "nix"], "modules: expected one that can be imported, got 'nix'"),
        (["bench", "--out", "/proc/nix"], "out: expected a folder that can be written, got '/proc/nix'"),
        (["report", "/nix"], "directory: expected one that holds records.jsonl, got '/nix'"),
        (["paper", "Z9"], "experiment: expected one of A2, A3, B1, B2, B3, C, D; got 'Z9'"),
        (["paper", "A2", "--renderer", "nix"], "renderer: expected one of raster, pybullet; got 'nix'"),
        (["render", "nix"], "scenario: expected one of road-town, .*road-town-v2.*; got 'nix'"),
        (["render", "--preset", "nix"], "preset: expected one of .*; got 'nix'"),
        (["render", "--seed", "-1"], "seed: expected a whole number >= 0, got -1"),
        (["render", "--tracker", "nix"], "tracker: expected one of .*; got 'nix'"),
        (["render", "--scale", "0.5"], "scale: expected a number from 1 to 8, got 0.5"),
        (["render", "--scale", "nan"], "scale: expected a number from 1 to 8, got nan"),
        (["render", "--scale", "200"], "scale: expected a number from 1 to 8, got 200"),
        (["render", "--out", "x.avi"], "out: expected a file that ends in .mp4, got 'x.avi'"),
        (["tune", "opencv_mil"], "tracker: expected one with tunable parameters, got 'opencv_mil', which has none"),
        (["tune", "--trials", "0"], "trials: expected a whole number >= 1, got 0"),
        (["train", "--preset", "paper-a3"], "pictures: expected --pictures, since road-town-.* has no env .*"),
        (
            ["train", "--controller", "none", "--controller-values", "a", "1"],
            "controller_values: expected none with controller none, got .*",
        ),
        (["tune", "--controllers", "centre", "nix"], "controller: expected one of .*; got 'nix'"),
        (
            ["train", "--fit-model", "1:2", "--check-model", "3:4"],
            "fit_model: expected it without check_model, got 1:2 with it",
        ),
        (
            ["train", "--pictures", "--starts", "frame-outs"],
            "starts: expected episodes with pictures, which begin on frame 0, got 'frame-outs'",
        ),
        (["tune", "--controllers", "centre_as_written"], "controllers: expected one that is used as tuned, got .*"),
        (
            ["generate", "road-town", "--seeds", "0:1", "--out", "set", "--set", "frame_count=0"],
            "frame_count: expected at least 107 for 2 or more frame-outs, got 0",
        ),
    ],
)
def test_what_is_wrong_is_reported_in_one_line(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    out, err = capsys.readouterr()
    # A fresh install also says, once, that it compiles.
    (line,) = (line for line in err.splitlines() if not line.startswith("compiling kernels"))
    assert out == ""
    assert re.fullmatch(f"error: {message}.*", line), line


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["bench", "--nix", "3"], "Unrecognized options: --nix"),
        (["bench", "--tracker", "hold"], "Unrecognized options: --tracker, hold .* Perhaps you meant: --trackers"),
        (["bench", "--workers", "two"], "Error parsing --workers: .*'two'"),
        (["bench", "--seeds", "5:"], "Error parsing --seeds: expected A:B with 0 <= A < B, or one seed, got '5:'"),
        (["bench", "--seeds", "5:5"], "Error parsing --seeds: .* got '5:5'"),
        (["bench", "--trackers", "--quick"], "Error parsing --trackers: expected one value or more, got none"),
        (["bench", "--trackers="], "Error parsing --trackers: expected one value or more, got none"),
        (["tune", "--fresh_preset", "--trials", "3"], "Error parsing --fresh-preset: expected one value or more"),
        (["tune", "hold", "--seeds", "9999:10001"], "Error parsing --seeds: expected development seeds, below 10000"),
        (["train", "--fit-model", "9999:10001"], "Error parsing --fit-model: expected development seeds, below 10000"),
        (["train", "--algorithm", "pp"], "invalid choice 'pp' for argument '--algorithm'.*'ppo', 'recurrent-ppo'"),
        (["train", "--controller-values", "wheels=3"], "Error parsing --controller-values: Failed to parse key-value"),
        (["report"], "Missing from frameout report: DIRECTORY"),
    ],
)
def test_words_that_are_no_options_are_told_by_tyro(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert re.search(message, " ".join(re.sub("[│╭╮╰╯─]", " ", err).split())), err


def test_without_optuna_tuning_names_the_command_that_installs_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At once: controllers would have their episodes planned first."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("benchmarks.run.packages.find_spec", lambda name: None)
    for named in (["colour_pf"], ["--controllers", "centre"]):
        assert main(["tune", *named]) == 2
        (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error")]
        assert "pip install 'frameout[tune]'" in line
    assert not list(tmp_path.iterdir())


def test_without_stable_baselines_training_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("benchmarks.run.packages.find_spec", lambda name: None)
    assert main(["train"]) == 2
    needed = "stable_baselines3, sb3_contrib, tensorboard"
    assert f"packages: expected {needed} to be installed (pip install 'frameout[train]')" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["lead"], "controller: expected one of .*; got 'lead', which steers a harbour-head"),
        (
            ["centre", "--controller-values", "wheels", "3"],
            "controller_values: centre: expected parameters among .*, got 'wheels'",
        ),
    ],
)
def test_a_wrong_controller_is_told_before_a_training_is_planned(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("benchmarks.cli.train.needs_stable_baselines", lambda: None)
    monkeypatch.setattr("benchmarks.cli.train.train", lambda *_: pytest.fail("it was planned"))
    assert main(["train", "frameout/RoadTownFollow-v3", "--controller", *words]) == 2
    assert re.search(told, capsys.readouterr().err)
    assert not list(tmp_path.iterdir())


def test_a_fault_of_the_program_is_not_dressed_up_as_a_wrong_argument(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*of: object) -> None:
        raise ValueError("zip() argument 2 is longer than argument 1")

    monkeypatch.setattr("benchmarks.cli.report.report_ignored_rows", broken)
    with pytest.raises(ValueError, match="zip"):
        main(["report", "/nix"])


@pytest.mark.parametrize(
    ("words", "where", "goes_on"),
    [
        (["list"], "list_all.console_of", False),
        (["render"], "render.render_episode", False),
        (["report", "/nix"], "report.report_ignored_rows", False),
        (["bench"], "bench.bench", True),
        (["paper", "A2"], "paper.repeat", True),
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

    # These come first, and what they ask for is an extra.
    monkeypatch.setattr("benchmarks.cli.tune.needs_optuna", lambda: None)
    monkeypatch.setattr("benchmarks.cli.train.needs_stable_baselines", lambda: None)
    monkeypatch.setattr(f"benchmarks.cli.{where}", stopped)
    assert main(words) == 130
    told = "stopped; the same command continues\n" if goes_on else "stopped\n"
    assert capsys.readouterr().err == told


def test_a_video_that_finds_no_room_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def render(scenario: str, out: Path, **_: object) -> Path:
        pictures = np.random.default_rng(0).integers(0, 255, (30, 64, 64, 3), dtype=np.uint8)
        with no_room(1000):
            write_mp4(out, ((picture, index / 15.0) for index, picture in enumerate(pictures)), 15.0)
        return out

    monkeypatch.setattr("benchmarks.cli.render.render_episode", render)
    assert main(["render", "--out", str(tmp_path / "x.mp4")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(r"error: .*x\.mp4.*: File too large; what was written before is kept\n", err)
    assert list(tmp_path.iterdir()) == []


def test_no_command_shows_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    shown = capsys.readouterr().out
    assert "frameout bench --quick" in shown
    assert max(map(len, shown.splitlines())) <= 80
    assert main(["--help"]) == 0
