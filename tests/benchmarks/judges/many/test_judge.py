"""The suite ``many``: on real sequences its scores are those of TrackEval, with distractors too."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd
import pytest
import trackeval

from benchmarks import bench, score
from benchmarks.data.tracked import read_tracked

NAME, FRAMES = "MOT17-99-FRCNN", 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a sequence of targets, distractors, cars and rows that do not count, and two trackers' rows."""
    root = tmp_path_factory.mktemp("many")
    sequence, rng = root / "gt" / "MOT17-train" / NAME, np.random.default_rng(5)
    (sequence / "gt").mkdir(parents=True)
    (sequence / "img1").mkdir()
    (root / "gt" / "seqmaps").mkdir()
    (root / "gt" / "seqmaps" / "MOT17-train.txt").write_text(f"name\n{NAME}\n")
    head = f"[Sequence]\nname={NAME}\nimDir=img1\nframeRate=25\nseqLength={FRAMES}\n"
    head += "imWidth=160\nimHeight=120\nimExt=.png\n"
    (sequence / "seqinfo.ini").write_text(head)
    kinds, truth, answers = [1, 1, 1, 1, 7, 8, 3], [], {"steady": [], "loose": []}
    places = rng.uniform(10, 110, (len(kinds), 2))
    for k in range(1, FRAMES + 1):
        cv2.imwrite(str(sequence / "img1" / f"{k:06d}.png"), np.full((120, 160, 3), 90, np.uint8))
        places += rng.normal(0, 2, places.shape)
        for number, (kind, (x, y)) in enumerate(zip(kinds, places, strict=True), start=1):
            counts = int(kind == 1 and not (number == 4 and k > 20))
            truth.append(f"{k},{number},{x:.2f},{y:.2f},20,30,{counts},{kind},1")
            for name, noise, share in (("steady", 1.0, 0.9), ("loose", 5.0, 0.7)):
                if rng.random() < share:
                    identity = number if name == "steady" or k < 15 else number + 10
                    left, top = np.array([x, y]) + rng.normal(0, noise, 2)
                    answers[name].append(f"{k},{identity},{left:.2f},{top:.2f},20,30,0.9,-1,-1,-1")
    (sequence / "gt" / "gt.txt").write_text("\n".join(truth))
    for name, rows in answers.items():
        (root / "answers" / "MOT17-train" / name / "data").mkdir(parents=True)
        (root / "answers" / "MOT17-train" / name / "data" / f"{NAME}.txt").write_text("\n".join(rows))
    return root


def _theirs(folder: Path) -> dict[str, Any]:
    """Return what TrackEval makes of it, with its preprocessing."""
    quiet = {"PRINT_CONFIG": False, "PRINT_RESULTS": False, "TIME_PROGRESS": False, "OUTPUT_SUMMARY": False}
    evaluator = trackeval.Evaluator(quiet | {"PLOT_CURVES": False, "OUTPUT_DETAILED": False, "LOG_ON_ERROR": None})
    folders = {"GT_FOLDER": str(folder / "gt"), "TRACKERS_FOLDER": str(folder / "answers")}
    kind = trackeval.datasets.MotChallenge2DBox(folders | {"BENCHMARK": "MOT17", "PRINT_CONFIG": False})
    metrics = trackeval.metrics
    chosen = [metric({"PRINT_CONFIG": False}) for metric in (metrics.HOTA, metrics.CLEAR, metrics.Identity)]
    found: dict[str, Any] = evaluator.evaluate([kind], chosen)[0]["MotChallenge2DBox"]
    return found


def test_predictions_on_a_real_sequence_have_trackeval_s_scores(folder: Path, tmp_path: Path) -> None:
    results = score(
        "many", real=folder / "gt/MOT17-train", predictions=folder / "answers/MOT17-train", out=tmp_path, workers=0
    )
    values = results.rows().pivot(index="tracker", columns="metric", values="value")
    shutil.copytree(folder / "gt", tmp_path / "labels", ignore=shutil.ignore_patterns("img1"))
    real = tmp_path / "labels" / "MOT17-train"
    alone = score("many", real=real, predictions=folder / "answers/MOT17-train", out=tmp_path / "alone", workers=0)
    pd.testing.assert_series_equal(alone.rows()["value"], results.rows()["value"])
    for name, theirs in _theirs(folder).items():
        if name in ("steady", "loose"):
            ours, expected = values.loc[name], theirs[NAME]["pedestrian"]
            assert ours["hota"] == pytest.approx(expected["HOTA"]["HOTA"].mean(), rel=1e-5)
            assert ours["mota"] == pytest.approx(expected["CLEAR"]["MOTA"], rel=1e-5)
            assert ours["identity_switches"] == expected["CLEAR"]["IDSW"]
            assert ours["identity_right_frames"] == expected["Identity"]["IDTP"]
            assert ours["identity_false_frames"] == expected["Identity"]["IDFP"]
            assert ours["identity_missed_frames"] == expected["Identity"]["IDFN"]
    assert values["identity_switches"].max() > 0
    assert set(results.rows()["sequence"]) == {NAME}


@pytest.mark.filterwarnings("ignore::benchmarks.run.outcome.TrackerWarning")
def test_trackers_of_many_run_on_real_pictures(folder: Path, tmp_path: Path) -> None:
    results = bench("many", real=folder / "gt/MOT17-train", trackers=["sort"], out=tmp_path, workers=0)
    assert {"hota", "mota"} <= set(results.rows()["metric"])
    assert not results.outcome.failures


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"layout": "otb"}, "layout: expected mot, in which all targets of many are read, and no target, got otb"),
        ({"target": 3}, "layout: expected mot, in which all targets of many are read, and no target, got target 3"),
        ({"real": "nix"}, "real: expected folders that exist, got 'nix'"),
    ],
)
def test_what_cannot_be_read_is_refused(folder: Path, tmp_path: Path, change: dict[str, Any], message: str) -> None:
    given = {"real": folder / "gt/MOT17-train", "predictions": folder / "answers/MOT17-train", "out": tmp_path / "out"}
    with pytest.raises(ValueError, match=message):
        score("many", **given | change)
    assert not (tmp_path / "out").exists()


def test_trackers_need_pictures(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder / "gt", tmp_path / "labels", ignore=shutil.ignore_patterns("img1"))
    with pytest.raises(ValueError, match="img1: expected pictures"):
        bench("many", real=tmp_path / "labels" / "MOT17-train", trackers=["sort"], out=tmp_path / "out")


@pytest.mark.parametrize("length", ["", "30.0", "-3", "1" * 30, "x"])
def test_the_length_is_needed_where_there_are_no_pictures(folder: Path, tmp_path: Path, length: str) -> None:
    shutil.copytree(folder / "gt/MOT17-train", tmp_path / "set")
    file = tmp_path / "set" / NAME / "seqinfo.ini"
    file.write_text(file.read_text().replace("seqLength=30", f"seqLength={length}"))
    sequences, unusable = read_tracked([tmp_path / "set"], None, labels_serve=True)
    assert (len(sequences), unusable) == (1, [])
    shutil.rmtree(file.parent / "img1")
    wanted = f"^{NAME}/seqinfo.ini: expected seqLength, imWidth and imHeight, whole numbers"
    with pytest.raises(ValueError, match=wanted):
        read_tracked([tmp_path / "set"], None, labels_serve=True)
