"""Real sequences from the command line: rows, resume, report, compare, ranks; and a simulated episode read back."""

from __future__ import annotations

import html
import json
import re
import shlex
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import Results
from benchmarks.cli.bench_function import bench as python_bench
from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.data.estimates.block_file import scan
from benchmarks.data.estimates.rejudging import rejudge
from benchmarks.data.exports.exporter import export
from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.sets.data_set import DataSet
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.outcome import TrackerWarning
from tests.benchmarks.data.exports.painted_scene import FRAMES as PAINTED_FRAMES
from tests.benchmarks.data.exports.painted_scene import WIDTH_PX, painted_data_set, truths
from tests.benchmarks.data.written_sequences import AWAY, FRAMES, lines_of, true_boxes, write_lines, write_otb
from trackers.kernels.boxes import box_iou
from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation

TRACKERS = ("fake_red", "fake_stays", "fake_breaks")


class _Fake:
    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._frame = 0

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self._box = box_xyxy

    def update(self, observation: Observation) -> Estimate:
        self._frame += 1
        return Estimate(0.5 * (self._box[:2] + self._box[2:]), self._box)


@register("fake_red", role="ours", summary="the box about all red pixels", suites=("frame-out",))
class Red(_Fake):
    """Is right wherever the box is seen."""

    def update(self, observation: Observation) -> Estimate:
        rows, columns = np.nonzero((observation.image_rgb == (220, 20, 20)).all(axis=2))
        if not len(rows):
            return Estimate(np.full(2, -50.0), in_view_probability=0.0)
        self._box = np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1], dtype=float)
        return Estimate(0.5 * (self._box[:2] + self._box[2:]), self._box, in_view_probability=1.0)


@register("fake_stays", role="external", summary="the first box", suites=("frame-out",))
class Stays(_Fake):
    """Never moves."""


@register("fake_breaks", role="external", summary="breaks on frame 30", suites=("frame-out",))
class Breaks(Red):
    """Is as good, and breaks."""

    def update(self, observation: Observation) -> Estimate:
        self._frame += 1
        if self._frame == 30:
            raise RuntimeError("no red on Tuesdays")
        return super().update(observation)


@register(
    "fake_runner", role="external", summary="six pixels a frame to the right, ever less sure", suites=("frame-out",)
)
class Runner(_Fake):
    """Follows the painted car nearly."""

    def update(self, observation: Observation) -> Estimate:
        self._frame += 1
        box = runner_box(self._box, self._frame)
        return Estimate(0.5 * (box[:2] + box[2:]), box, in_view_probability=runner_probability(self._frame))


def runner_box(first: NDArray[np.float64], frame: int) -> NDArray[np.float64]:
    step = np.array([6.0, 0.25]) * frame
    return first + np.concatenate([step, step]) + np.array([0.0, 0.0, 0.6, 0.4])


def runner_probability(frame: int) -> float:
    return float(np.clip(1.0 - 0.12 * frame, 0.0, 1.0))


def bench(real: Path, out: Path, *more: str) -> int:
    words = ["bench", "frame-out", "--real", str(real), "--trackers", *TRACKERS, "--out", str(out)]
    return main([*words, "--workers", "0", *more])


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("real")
    for name in ("Car1", "Car2"):
        write_otb(folder / "cars" / name)
    write_otb(folder / "cars" / "Car3", true_boxes(away=range(0)))
    assert bench(folder / "cars", folder / "out") == 1
    return folder


def summary(folder: Path) -> dict[tuple[str, str], dict[str, Any]]:
    entries = json.loads((folder / "out" / "summary.json").read_text())
    return {(entry["tracker"], entry["metric"]): entry for entry in entries}


@pytest.mark.heavy
def test_means_are_over_sequences(ran: Path) -> None:
    rows = read_rows(ran / "out")
    assert {(row["scenario"], row["preset"], row["renderer"], row["controller"]) for row in rows} == {
        ("real", "cars", "real", None)
    }
    assert {(row["seed"], row["sequence"]) for row in rows} == {(0, "Car1"), (1, "Car2"), (2, "Car3")}
    found = summary(ran)
    right, still = found["fake_red", "success_auc"], found["fake_stays", "success_auc"]
    # IoU 1 is above 20 of 21 thresholds.
    assert (right["mean"], right["n"], right["role"]) == (pytest.approx(20 / 21, abs=1e-6), 3, "ours")
    assert 0.0 < still["mean"] < 0.3
    assert found["fake_red", "in_view_gm"]["mean"] == 1.0
    assert (found["fake_red", "recovery_rate"]["mean"], found["fake_red", "recovery_rate"]["n"]) == (1.0, 2)
    assert found["fake_stays", "in_view_tnr"]["mean"] == 0.0
    assert found["fake_red", "f_measure"]["mean"] == pytest.approx(1.0)
    assert not {"offscreen_error_m", "coverage_95", "wrong_car_rate"} & {metric for _, metric in found}


def test_a_tracker_that_breaks_is_scored_to_the_end(ran: Path) -> None:
    seen_before = np.mean([k < 30 or k in AWAY for k in range(FRAMES) if k not in AWAY])
    rows = [row for row in read_rows(ran / "out") if row["tracker"] == "fake_breaks" and row["sequence"] == "Car1"]
    values = {row["metric"]: row["value"] for row in rows if row["frame_out"] is None}
    assert values["in_view_tpr"] == pytest.approx(seen_before, abs=1e-5)
    assert values["failed_at_frame"] == 30


@pytest.mark.heavy
def test_the_same_command_continues_and_a_new_annotation_is_run_again(
    ran: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def seconds() -> dict[tuple[str, int], float]:
        return {(row["tracker"], row["seed"]): row["seconds"] for row in read_rows(ran / "out")}

    truth = ran / "cars" / "Car2" / "groundtruth_rect.txt"
    before, written = seconds(), truth.read_text()
    assert bench(ran / "cars", ran / "out") == 1
    assert seconds() == before
    assert "no red on Tuesdays (in an earlier run, whose rows are kept" in capsys.readouterr().err
    try:
        write_lines(truth, lines_of(true_boxes(away=range(15, 21))))
        assert bench(ran / "cars", ran / "out") == 1
        rows = [row for row in read_rows(ran / "out") if row["sequence"] == "Car2" and row["metric"] == "in_view_tnr"]
        assert {row["weight"] for row in rows} == {6.0}
        assert "rows that are outdated" in capsys.readouterr().err
    finally:
        truth.write_text(written)
        bench(ran / "cars", ran / "out")


def test_the_report_shows_an_absence_as_long_as_the_sequence_is_what_was_run(
    ran: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = shutil.copytree(ran / "out", tmp_path / "out")
    (words,) = [json.loads(file.read_text()) for file in (out / "pictures").glob("*.json")]
    first = AWAY.start
    assert words["title"] == "One absence"
    assert words["caption"].startswith("Sequence Car1: the first absence, just before, in its middle, at its end, and")
    assert json.loads(words["made_from"])[0][1] == [first - 1, first + len(AWAY) // 2, AWAY.stop, AWAY.stop + 5]
    sheet = cv2.imread(str(next((out / "pictures").glob("*.jpg"))))
    # A line of four pictures of 600 pixels for ours and each one of a user's own.
    assert sheet.shape[1] == 4 * 606 - 6
    assert len(json.loads(words["made_from"])[1]) == len(TRACKERS)
    # The picture is made again from the rows, and while it is, the frames are counted.
    before = sheet.tobytes()
    next((out / "pictures").glob("*.json")).unlink()
    capsys.readouterr()
    assert main(["report", str(out)]) == 0
    count = AWAY.stop + 6
    assert f"picture of frame-out-real-cars-real, frames: {count} of {count}, " in capsys.readouterr().err
    assert cv2.imread(str(next((out / "pictures").glob("*.jpg")))).tobytes() == before
    # The boxes are others now: the runs cannot be repeated.
    truth = ran / "cars" / "Car1" / "groundtruth_rect.txt"
    written = truth.read_text()
    try:
        write_lines(truth, lines_of(true_boxes(away=range(15, 21))))
        next((out / "pictures").glob("*.json")).unlink()
        assert main(["report", str(out)]) == 0
        assert not list((out / "pictures").iterdir())
    finally:
        truth.write_text(written)


def test_the_table_and_the_curves_are_those_of_sequences(ran: Path, tmp_path: Path) -> None:
    results = Results(ran / "out")
    table = results.by_episode("success_auc")
    assert list(table.index.get_level_values("episode")) == ["Car1", "Car2", "Car3"]
    found = summary(ran)
    for name in TRACKERS:
        assert table[name].mean() == pytest.approx(found[name, "success_auc"]["mean"], abs=1e-5)
    titles = [figure.get_suptitle() for figure in results.figures()]
    assert {"How well do the boxes fit?", "How near are the centres?", "What does a better score cost?"} <= {*titles}
    assert "Each sequence: success AUC (%) ↑" in (ran / "out" / "report.html").read_text()


@pytest.mark.heavy
def test_leaderboard_report_and_compare_speak_of_sequences(ran: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench(ran / "cars", ran / "out")
    told = capsys.readouterr()
    assert "real, cars, real: 3 sequences" in told.out
    assert "cars: 3 sequences, 180 frames; 2 absences of 5 frames; 2 with a return that is judged" in told.out
    assert "tell no focal length: 1.2 times the longer side" in told.err
    assert main(["report", str(ran / "out"), "--markdown"]) == 0
    assert "| `fake_red` " in capsys.readouterr().out
    page = (ran / "out" / "report.html").read_text()
    assert "real sequences" in page
    assert "a car seen from a helicopter" not in page
    assert "Intervals are 95 % bootstrap over sequences" in page
    assert "Definitions of the metrics of suite frame-out on real sequences" in page
    assert "of a point alone, in the middle half of the true box" in page
    assert "half its length on the ground" not in page
    assert "offscreen_error" not in page
    linked = set(re.findall(r'href="#(frame-out[^"]*)"', page))
    assert linked <= set(re.findall(r'<dt id="([^"]*)"', page))
    assert "frame-out-real-success_auc" in linked
    assert main(["compare", "fake_red", "fake_stays", "--directory", str(ran / "out")]) == 0
    told = capsys.readouterr()
    assert "whole episodes" in told.out
    assert "success_auc" in told.out


@pytest.mark.heavy
def test_the_command_of_the_report_makes_the_same_rows_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another rate is another run: trackers are told the time of each picture."""
    monkeypatch.chdir(tmp_path)
    write_otb(tmp_path / "my cars" / "Car1")
    (tmp_path / "mine.py").write_text("")
    assert bench(Path("my cars/Car1"), Path("out"), "--rate-hz", "12.5", "--modules", "mine.py") == 1
    assert "frame 30: RuntimeError: no red on Tuesdays (test_real_sequences.py, line " in capsys.readouterr().err
    page = html.unescape((tmp_path / "out" / "report.html").read_text())
    (command,) = re.findall("<code>(frameout bench .*)</code>", page)
    assert main([*shlex.split(command)[1:], "--out", "again", "--workers", "0"]) == 1
    first, second = ([_without_times(row) for row in read_rows(tmp_path / name)] for name in ("out", "again"))
    assert first == second
    # One sequence tells nothing of how sequences differ.
    assert {entry["ci_low"] for entry in json.loads((tmp_path / "out" / "summary.json").read_text())} == {None}


def _without_times(row: dict[str, Any]) -> dict[str, Any]:
    timed = row["metric"] in TIMES
    return {name: value for name, value in row.items() if name != "seconds" and not (timed and name == "value")}


@pytest.mark.heavy
def test_ranks_stand_beside_those_of_simulated_rows(ran: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = (ran / "out" / "records.jsonl").read_text().splitlines()
    simulated = [json.loads(line) | {"scenario": "town-v1", "renderer": "raster"} for line in lines]
    (ran / "sim").mkdir(exist_ok=True)
    write_lines(ran / "sim" / "records.jsonl", [json.dumps(row) for row in simulated])
    bench(ran / "cars", ran / "out", "--beside", str(ran / "sim"))
    told = capsys.readouterr().out
    assert "success_auc, real cars and town-v1 cars raster: Kendall's tau 1.00, " in told
    assert "recovered counts, simulated: frame-outs with at least 5 frames" in told
    assert "real: fake_red 0.952, fake_breaks " in told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["frame-out", "--real", "nowhere"], "real: expected folders that exist, got "),
        (["frame-out", "--layout", "otb"], "layout: expected none but with --real and a suite that judges pictures"),
        (["frame-out", "--real", "CARS", "--seeds", "0:2"], "seeds: expected none with --real, which runs no episodes"),
        (["frame-out", "--real", "CARS", "--trackers", "blind_below"], "which need pictures alone, got 'blind_below'"),
        (["frame-out", "--real", "CARS", "--beside", "nowhere"], "directory: expected one that holds records.jsonl"),
        (["frame-out", "--real", "CARS", "--rate-hz", "0"], "rate_hz: expected a number of frames a second > 0, got 0"),
        (["fish", "--real", "CARS", "--layout", "otb"], "layout: expected none but with --real and a suite that"),
    ],
)
def test_wrong_arguments_are_named(
    ran: Path, words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [str(ran / "cars") if word == "CARS" else word for word in words]
    assert main(["bench", *words, "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


def test_a_suite_without_recordings_names_those_that_have_some(
    ran: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "stereo", "--real", str(ran / "cars"), "--out", str(tmp_path)]) == 2
    refused = r"real: expected a suite that judges recordings \(.*\bfish, frame-out\b.*\), got stereo"
    assert re.search(refused, capsys.readouterr().err)


FEW = true_boxes(12, range(3, 6))


def test_a_bad_sequence_is_named_and_the_rest_is_scored(tmp_path: Path) -> None:
    """And once it is mended it alone is run."""
    cars = tmp_path / "cars"
    for name in ("Car1", "Car2", "Car3", "Car4"):
        write_otb(cars / name, FEW)
    whole = (cars / "Car2" / "img" / "0007.png").read_bytes()
    (cars / "Car2" / "img" / "0007.png").write_bytes(whole[:40])
    boxes = cars / "Car3" / "groundtruth_rect.txt"
    boxes.write_text(boxes.read_text() + "1,1,2,2\n")
    given: dict[str, Any] = {"real": cars, "trackers": "fake_stays", "out": tmp_path / "out", "workers": 0}
    with pytest.warns(TrackerWarning, match=r"Car[23]/"):
        outcome = python_bench("frame-out", **given).outcome
    assert list(outcome.problems_in_words("nothing")) == [
        "error: Car3/groundtruth_rect.txt: expected 12 boxes, one a picture, got 13",
        "error: Car2/img/0007.png: expected a whole picture, got 40 bytes that are none, or a part of one",
    ]
    named = {row["sequence"]: (row["seed"], row["seconds"]) for row in read_rows(tmp_path / "out")}
    assert {name: seed for name, (seed, _) in named.items()} == {"Car1": 0, "Car4": 3}
    (cars / "Car2" / "img" / "0007.png").write_bytes(whole)
    write_lines(boxes, lines_of(FEW))
    assert not python_bench("frame-out", **given).outcome.failed
    again = {row["sequence"]: (row["seed"], row["seconds"]) for row in read_rows(tmp_path / "out")}
    assert {name: seed for name, (seed, _) in again.items()} == {"Car1": 0, "Car2": 1, "Car3": 2, "Car4": 3}
    assert {name: again[name] for name in named} == named


def test_a_single_sequence_that_is_broken_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = write_otb(tmp_path / "Car1", FEW)
    (folder / "img" / "0007.png").write_bytes(b"gone")
    assert bench(folder, tmp_path / "out") == 2
    assert "error: Car1/img/0007.png: expected a whole picture, got 4 bytes that are" in capsys.readouterr().err
    assert not (tmp_path / "out" / "records.jsonl").exists()


@pytest.fixture
def mortals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of two short sequences, which is the current one."""
    monkeypatch.chdir(tmp_path)
    for name in ("Car1", "Car2"):
        write_otb(tmp_path / "cars" / name, FEW)
    return tmp_path


def mortal_bench(out: str, *trackers: str, workers: int = 1) -> int:
    words = [
        "bench",
        "frame-out",
        "--modules",
        "tests.benchmarks.run.mortals",
        "--real",
        "cars",
        "--trackers",
        *trackers,
    ]
    return main([*words, "--workers", str(workers), "--out", out])


@pytest.mark.heavy
def test_trackers_that_end_their_process_cost_their_own_rows_alone(
    mortals: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert mortal_bench("all", "exits", "innocent", "crashes", "stillborn", "raises", workers=2) == 1
    told = capsys.readouterr().err
    # Which of both sequences comes first depends on the workers.
    ended = {"exits": "5: ended its process", "crashes": "5: ended its process", "stillborn": "0: ended its process"}
    for name, how in (ended | {"raises": r"5: RuntimeError: no \(mortals.py, line "}).items():
        assert re.search(f"error: {name} failed in real cars, sequence Car[12], frame {how}", told), name
    failed = {(row["tracker"], row["value"]) for row in read_rows(Path("all")) if row["metric"] == "failed_at_frame"}
    assert failed == {("exits", 5.0), ("crashes", 5.0), ("stillborn", 0.0), ("raises", 5.0)}
    page = Path("all/report.html").read_text()
    assert "exits, sequence Car2: failed at frame 5" in html.unescape(page)
    assert "sequences Car1, Car2" in page
    # In the same folder they are told again, and are not run.
    assert mortal_bench("all", "exits", "innocent") == 1
    assert "exits failed in real cars, sequence Car1, frame 5: ended its process" in capsys.readouterr().err
    assert mortal_bench("one", "innocent", workers=0) == 0
    alone, beside = (
        [_without_times(row) for row in read_rows(Path(name)) if row["tracker"] == "innocent"]
        for name in ("one", "all")
    )
    assert json.dumps(alone) == json.dumps(beside)


def test_a_tracker_without_its_package_has_no_rows(mortals: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert mortal_bench("out", "unequipped", "innocent", workers=0) == 1
    assert "unequipped failed in real cars, sequence Car1, frame 0: PackageNotFoundError" in capsys.readouterr().err
    assert {row["tracker"] for row in read_rows(Path("out"))} == {"innocent"}
    assert mortal_bench("alone", "unequipped", workers=0) == 2
    assert "error: trackers: expected some that can begin, got unequipped failed" in capsys.readouterr().err


def test_one_that_needs_an_environment_is_refused_with_how_to_make_it(
    mortals: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/nonexistent")
    assert mortal_bench("out", "opencv_csrt", "innocent", workers=0) == 2
    told = capsys.readouterr().err
    assert "trackers: expected ones of which all that they need is installed, got opencv_csrt: its environment" in told
    assert not Path("out").exists()


def test_a_run_from_python_has_the_column_of_sequences_and_its_answers(mortals: Path) -> None:
    done: list[tuple[int, int]] = []

    @contextmanager
    def progress(title: str) -> Iterator[Callable[[int, int], None]]:
        assert title == "frame-out, 1 tracker"
        yield lambda count, of: done.append((count, of))

    results = python_bench(
        "frame-out",
        real="cars",
        trackers="fake_stays",
        out="out",
        workers=0,
        keep_estimates=True,
        rate_hz=10.0,
        progress=progress,
    )
    rows = results.rows()
    assert set(zip(rows["seed"], rows["sequence"], strict=True)) == {(0, "Car1"), (1, "Car2")}
    assert done == [(0, 2), (1, 2), (2, 2)]
    said = scan("out").to_table().to_pandas()
    assert sorted(said.groupby("seed").size().tolist()) == [12, 12]
    with pytest.raises(ValueError, match=r"^estimates: expected ones of simulated episodes, got those of real cars$"):
        rejudge(Path("out"), None, 0, (), lambda done, of: None)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"preset": "quick"}, r"^preset: expected none with --real, which runs no episodes, got \('quick',\)$"),
        ({"seeds": range(3)}, r"^seeds: expected none with --real, which runs no episodes, got range\(0, 3\)$"),
        ({"renderer": "pybullet"}, r"^renderer: expected raster with --real, which draws nothing, got 'pybullet'$"),
        ({"data": "set"}, r"^data: expected none with --real, which runs no episodes, got 'set'$"),
        ({"real": ()}, r"^seeds: expected range\(A, B\), got None$"),
    ],
)
def test_wrong_arguments_from_python_are_named(mortals: Path, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        python_bench("frame-out", **{"real": "cars", "trackers": "fake_stays", "out": "out", **given})


@pytest.mark.heavy
def test_rows_of_what_is_gone_or_has_changed_are_moved_aside(mortals: Path) -> None:
    """Also those of a tracker that does not run: they would be compared with rows on other pictures."""
    given: dict[str, Any] = {"real": "cars", "out": "out", "workers": 0}
    python_bench("frame-out", trackers=["fake_stays", "fake_red"], **given)
    (mortals / "cars" / "Car1" / "img" / "0002.png").write_bytes(
        (mortals / "cars" / "Car1" / "img" / "0001.png").read_bytes()
    )
    results = python_bench("frame-out", trackers=["fake_stays"], **given)
    assert (results.outcome.resumed, results.outcome.episodes) == (1, 1)
    left = {(row["tracker"], row["sequence"]) for row in read_rows(Path("out"))}
    assert left == {("fake_stays", "Car1"), ("fake_stays", "Car2"), ("fake_red", "Car2")}
    shutil.rmtree(mortals / "cars" / "Car2")
    # Of one sequence the collection has its name.
    write_otb(mortals / "cars" / "Car0", FEW)
    python_bench("frame-out", trackers=["fake_stays"], **given)
    left = {(row["tracker"], row["sequence"], row["seed"]) for row in read_rows(Path("out"))}
    assert left == {("fake_stays", "Car0", 0), ("fake_stays", "Car1", 1)}


def test_sequences_of_one_name_that_differ_are_not_compared(mortals: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for out, away in (("one", range(3, 6)), ("two", range(3, 7))):
        write_otb(mortals / "cars" / "Car1", true_boxes(12, away))
        python_bench("frame-out", real="cars", trackers="fake_stays", out=out, workers=0)
    assert main(["compare", "one:fake_stays", "two:fake_stays"]) == 2
    assert "directory: expected results on the same recordings, got others called cars" in capsys.readouterr().err


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exported")
    export(painted_data_set(folder / "set"), "otb", folder / "otb")
    return folder / "otb"


def directly(score: Callable[[NDArray[np.float64], NDArray[np.bool_]], Any]) -> Any:
    """Score the runner by the truth of the simulated episode, on the frames that show a pixel of the car."""
    shown = np.array([truth.visible_fraction[1] > 0 for truth in truths()])
    true_box = np.array([truth.box_xyxy[1] for truth in truths()])
    box = np.array([runner_box(true_box[0], k) if k else true_box[0] for k in range(PAINTED_FRAMES)])
    return score(box_iou(box, true_box), shown)


def success_auc(iou: NDArray[np.float64], shown: NDArray[np.bool_]) -> float:
    return float(np.mean([np.mean(iou[shown] > t / 20) for t in range(21)]))


def best_f(iou: NDArray[np.float64], shown: NDArray[np.bool_]) -> float:
    sure = np.array([1.0, *(runner_probability(k) for k in range(1, PAINTED_FRAMES))])
    first = truths()[0].box_xyxy[1]
    inside = np.array([0.5 * runner_box(first, k)[::2].sum() < WIDTH_PX for k in range(PAINTED_FRAMES)])
    best = 0.0
    for t in range(21):
        said = inside & (sure >= t / 20) & (sure > 0)
        total = float(iou[said & shown].sum())
        precision, recall = total / said.sum() if said.any() else 1.0, total / shown.sum()
        best = max(best, 2 * precision * recall / (precision + recall) if precision + recall else 0.0)
    return best


def test_an_exported_episode_read_back_has_the_scores_of_the_simulated_one(exported: Path, tmp_path: Path) -> None:
    (collection,) = read_collections([exported])
    for sequence in collection.sequences:
        for box, truth in zip(sequence.box_xyxy, truths(), strict=True):
            expected = truth.box_xyxy[1] if truth.visible_fraction[1] > 0 else np.full(4, np.nan)
            np.testing.assert_allclose(box, expected, atol=1e-3)
    out = tmp_path / "out"
    words = ["bench", "frame-out", "--real", str(exported), "--trackers", "fake_runner", "--workers", "0"]
    assert main([*words, "--out", str(out)]) == 0
    found = {entry["metric"]: entry["mean"] for entry in json.loads((out / "summary.json").read_text())}
    assert found["success_auc"] == pytest.approx(directly(success_auc), abs=1e-5)
    assert found["f_measure"] == pytest.approx(directly(best_f), abs=1e-5)
    assert 0.2 < found["success_auc"] < 0.95


PIXELS = ("success_auc", "success_curve", "precision_20_px", "precision_curve", "recall_curve", "in_view_tnr")
"""Scores that simulated episodes and sequences define alike, where no picture shows a part of the target."""


@pytest.mark.heavy
def test_a_stored_set_and_its_exports_have_the_same_scores_in_pixels(tmp_path: Path) -> None:
    """Of a tracker that needs pictures alone; formats that tell the same have the same rows in full."""
    words = ["generate", "road-town", "--preset", "quick", "--seeds", "0", "--pictures", "png", "--workers", "0"]
    assert main([*words, "--out", str(tmp_path / "set")]) == 0
    given: dict[str, Any] = {"trackers": "hold", "workers": 0}
    stored = python_bench("frame-out", data=str(tmp_path / "set"), seeds=range(1), out=tmp_path / "stored", **given)
    told = {}
    for name, target in (("vot", None), ("webdataset", "target"), ("tao-amodal", "target")):
        export(DataSet(str(tmp_path / "set")), name, tmp_path / name)
        real = python_bench("frame-out", real=tmp_path / name, target=target, out=tmp_path / f"{name}-out", **given)
        told[name] = _values_of(real.directory)
        assert told[name] == told["vot"]
    simulated = _values_of(stored.directory)
    for metric in PIXELS:
        assert told["vot"][metric, None] == simulated[metric, None], metric
    (event,) = {key[1] for key in told["vot"] if key[1] is not None and key[0] == "watched_frames"}
    assert ("watched_frames", event) in simulated


def _values_of(folder: Path) -> dict[tuple[str, tuple[int, int, int] | None], Any]:
    """Return the values of rows but times, by metric and frame-out: its exit, length and return."""
    found = {}
    for row in read_rows(folder):
        event = row["frame_out"]
        place = None if event is None else (event["exit_frame"], event["length_frames"], event["back_frame"])
        if row["metric"] not in TIMES:
            found[row["metric"], place] = row["value"]
    return found
