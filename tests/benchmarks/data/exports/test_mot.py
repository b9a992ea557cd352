"""MOT exports, read by the rules of MOT Challenge and scored against themselves."""

from __future__ import annotations

import configparser
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trackeval

from tests.benchmarks.data.exports.painted_scene import FRAMES, NAMES, truths

Rows = dict[int, dict[int, np.ndarray]]


@pytest.fixture(scope="module")
def sequence(exported: Callable[[str], Path]) -> Path:
    root = exported("mot") / "gt" / "mot_challenge"
    heading, *names = (root / "seqmaps" / "frameout-train.txt").read_text().split()
    assert heading == "name"
    assert names == ["painted-v1-quick-000003", "painted-v1-quick-000004"]
    return root / "frameout-train" / names[1]


def rows_of(sequence: Path) -> Rows:
    """Return frame -> identity -> (left, top, width, height, counts, class, visibility), frames and pixels from 1."""
    rows: Rows = {}
    for line in (sequence / "gt" / "gt.txt").read_text().splitlines():
        frame, identity, *rest = line.split(",")
        assert len(rest) == 7
        assert int(identity) not in rows.setdefault(int(frame), {})
        rows[int(frame)][int(identity)] = np.array(rest, float)
    return rows


def test_trackeval_reads_it_and_scores_truth_against_itself_with_100(sequence: Path, tmp_path: Path) -> None:
    scored = scored_against_itself(sequence.parent, tmp_path)
    np.testing.assert_allclose(scored["HOTA"]["HOTA"], 1.0)
    assert scored["Identity"]["IDF1"] == 1.0
    assert scored["Identity"]["IDTP"] == sum(len(rows) for rows in rows_of(sequence).values()) * 2


def scored_against_itself(sequences: Path, answered: Path) -> Any:
    """Return what TrackEval 1.3, the metrics' own implementation, says of truth; it has no interface but folders.

    Args:
        answered: a folder for what it reads as answers.
    """
    answers = answered / "frameout-train" / "truth" / "data"
    answers.mkdir(parents=True)
    for each in sequences.iterdir():
        shutil.copy(each / "gt" / "gt.txt", answers / f"{each.name}.txt")
    quiet = {"PRINT_CONFIG": False, "PRINT_RESULTS": False, "TIME_PROGRESS": False, "OUTPUT_SUMMARY": False}
    evaluator = trackeval.Evaluator(quiet | {"PLOT_CURVES": False, "OUTPUT_DETAILED": False, "LOG_ON_ERROR": None})
    folders = {"GT_FOLDER": str(sequences.parent), "TRACKERS_FOLDER": str(answered)}
    names = {"BENCHMARK": "frameout", "DO_PREPROC": False, "PRINT_CONFIG": False}
    kind = trackeval.datasets.MotChallenge2DBox(folders | names)
    quiet_metrics = [metric({"PRINT_CONFIG": False}) for metric in (trackeval.metrics.HOTA, trackeval.metrics.Identity)]
    results, _ = evaluator.evaluate([kind], quiet_metrics)
    return results["MotChallenge2DBox"]["truth"]["COMBINED_SEQ"]["pedestrian"]


def test_rows_are_the_truth_counted_from_one(sequence: Path) -> None:
    rows = rows_of(sequence)
    objects = dict(line.split(",")[:2] for line in (sequence / "gt" / "objects.txt").read_text().splitlines())
    for frame, truth in enumerate(truths(), start=1):
        listed = {objects[str(identity)]: row for identity, row in rows[frame].items()}
        has_row = [n for n, s, b in zip(NAMES, truth.state, truth.box_xyxy, strict=True) if s != "out" and b[0] == b[0]]
        assert set(listed) == set(has_row)
        for name, row in listed.items():
            k = truth.index_of(name)
            x_min, y_min, x_max, y_max = truth.box_xyxy[k]
            np.testing.assert_allclose(row[:4], [x_min + 1, y_min + 1, x_max - x_min, y_max - y_min], atol=1e-3)
            assert tuple(row[4:6]) == (1, 1)
            assert row[6] == pytest.approx(truth.visible_fraction[k], abs=1e-5)
    assert any("target" not in {objects[str(i)] for i in rows[f]} for f in rows)


def test_seqinfo_describes_the_pictures(sequence: Path) -> None:
    parser = configparser.ConfigParser()
    parser.read(sequence / "seqinfo.ini")
    info = parser["Sequence"]
    assert info["name"] == sequence.name
    assert (int(info["imWidth"]), int(info["imHeight"]), int(info["seqLength"])) == (40, 32, FRAMES)
    # mmtracking's mot2coco takes int() of it, which a rate of 0.5 Hz as it is would end.
    assert (int(info["frameRate"]), float(info["exactFrameRate"])) == (8, 7.5)
    pictures = [f"{frame:06d}{info['imExt']}" for frame in range(1, FRAMES + 1)]
    assert sorted(path.name for path in (sequence / info["imDir"]).iterdir()) == pictures
