"""YOLO and DOTA exports, read by the rules of Ultralytics and of DOTA's devkit; and the split."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.exports.exporter import export
from benchmarks.data.exports.yolo import parts_of
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.exports.painted_scene import (
    FRAMES,
    HEIGHT_PX,
    IDS,
    KINDS,
    WIDTH_PX,
    cars_in_some,
    painted_data_set,
    truths,
)
from tests.benchmarks.data.exports.scoring import Box, average_precision
from tests.benchmarks.data.exports.test_outlines import filled

yaml = pytest.importorskip("yaml")


def test_labels_are_boxes_around_what_is_seen(exported: Callable[[str], Path]) -> None:
    out = exported("yolo")
    described = yaml.safe_load((out / "data.yaml").read_text())
    assert described["names"] == {0: "bus", 1: "car", 2: "kite"}
    for part, seed in (("train", 3), ("val", 4)):
        pictures = sorted((out / described[part]).iterdir())
        assert [path.stem for path in pictures] == [
            f"painted-v1-quick-{seed:06d}_{frame:06d}" for frame in range(FRAMES)
        ]
        for picture, truth in zip(pictures, truths(), strict=True):
            # Readers exchange the last folder called images for labels.
            label = out / "labels" / part / f"{picture.stem}.txt"
            rows = [line.split() for line in label.read_text().splitlines()]
            shown = [k for k in range(3) if (truth.instance_map == IDS[k]).any()]
            assert sorted(described["names"][int(row[0])] for row in rows) == sorted(KINDS[k] for k in shown)
            for row in rows:
                mask = truth.instance_map == IDS[KINDS.index(described["names"][int(row[0])])]
                x, y, width, height = scaled(row)
                y_in, x_in = np.nonzero(mask)
                np.testing.assert_allclose([x - width / 2, x + width / 2], [x_in.min(), x_in.max() + 1], atol=1e-5)
                np.testing.assert_allclose([y - height / 2, y + height / 2], [y_in.min(), y_in.max() + 1], atol=1e-5)


def scaled(row: list[str]) -> np.ndarray:
    """Return x and y of the centre, width and height in pixels."""
    return np.array(row[1:], float) * [WIDTH_PX, HEIGHT_PX, WIDTH_PX, HEIGHT_PX]


def test_whole_episodes_are_validated_on(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(3, 13))
    assert list(parts_of(data).values()) == ["train"] * 8 + ["val"] * 2
    data.request = replace(data.request, splits={"train": 0.5, "val": 0.3, "test": 0.2})
    assert parts_of(data) == {seed: data.request.split_of(seed) for seed in range(3, 13)}
    whole = r"episodes to train on and to validate on \(more seeds, other splits\), or for test alone"
    with pytest.raises(ValueError, match=rf"data: expected {whole}, got 1 for train, 0 for val, 0 for test"):
        parts_of(painted_data_set(tmp_path / "one", seeds=(3, 4)))


def read_like_ultralytics(out: Path) -> dict[str, list[Path]]:
    """Return the pictures of each split that ``data.yaml`` names; ``check_det_dataset`` refuses one whose ``train`` or
    ``val`` is not named, or whose pictures of ``val`` are not there.
    """
    described = yaml.safe_load((out / "data.yaml").read_text())
    assert {"train", "val", "names"} <= set(described)
    assert any((out / described["val"]).iterdir())
    splits = {split: out / described[split] for split in ("train", "val", "test") if split in described}
    return {split: sorted(folder.iterdir()) if folder.exists() else [] for split, folder in splits.items()}


def test_a_set_can_be_trained_on_or_is_refused(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 5))
    data.request = replace(data.request, splits={"train": 0.5, "val": 0.5})
    export(data, "yolo", tmp_path / "good")
    pictures = read_like_ultralytics(tmp_path / "good")
    assert {split: len(found) for split, found in pictures.items()} == {
        split: FRAMES * len(seeds) for split, seeds in data.splits.items()
    }
    for splits, got in (({"train": 1.0}, "5 for train, 0 for val"), ({"val": 0.5, "test": 0.5}, "0 for train")):
        data.request = replace(data.request, splits=splits)
        for name in ("yolo", "yolo-obb", "dota"):
            with pytest.raises(ValueError, match=f"data: expected episodes to train on and to validate on .*{got}"):
                export(data, name, tmp_path / "bad")
    data = cars_in_some(tmp_path / "few")
    with pytest.raises(ValueError, match=r"data: expected pictures to train on .* got 0 for train, 6 for val"):
        export(data, "yolo", tmp_path / "bad")
    assert not (tmp_path / "bad").exists()


def test_the_test_split_is_never_trained_on(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "mixed", seeds=(9998, 10001))
    assert parts_of(data) == {9998: "train", 9999: "val", 10000: "test"}
    export(painted_data_set(tmp_path / "set", seeds=(10000, 10002)), "yolo", tmp_path / "out")
    pictures = read_like_ultralytics(tmp_path / "out")
    assert pictures["train"] == []
    assert pictures["val"] == pictures["test"]
    assert len(pictures["test"]) == 2 * FRAMES


def labels_of(out: Path, classes: int = 3) -> dict[str, list[np.ndarray]]:
    """Return the rows of each picture of a YOLO folder, by its name, as Ultralytics' ``verify_image_label`` reads them.

    Rows of more than six numbers are outlines; of those boxes are made, and centres and sizes checked.
    """
    found = {}
    for file in sorted(out.glob("labels/*/*.txt")):
        rows = [np.array(line.split(), np.float64) for line in file.read_text().splitlines()]
        outlines = any(len(row) > 6 for row in rows)
        for row in rows:
            checked = row[1:]
            if outlines:
                points = row[1:].reshape(-1, 2)
                low, high = points.min(axis=0), points.max(axis=0)
                checked = np.concatenate([0.5 * (low + high), high - low])
            assert len(checked) == 4
            assert checked.max() <= 1.01
            assert checked.min() >= -0.01
            assert row[0] < classes
        found[file.stem] = rows
    return found


def true_boxes(seeds: tuple[int, ...] = (3, 4)) -> list[Box]:
    """Return the boxes around what is seen of each object in each picture."""
    boxes = []
    for seed in seeds:
        for frame, truth in enumerate(truths()):
            for number, identity in enumerate(IDS):
                y, x = np.nonzero(truth.instance_map == identity)
                if len(x):
                    kind = ("bus", "car", "kite").index(KINDS[number])
                    box = np.array([x.min(), y.min(), x.max() + 1, y.max() + 1], float)
                    boxes.append((f"painted-v1-quick-{seed:06d}_{frame:06d}", kind, box))
    return boxes


def around(points: np.ndarray) -> np.ndarray:
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


def test_truth_against_what_is_read_is_perfect(exported: Callable[[str], Path]) -> None:
    boxes = [
        (name, int(row[0]), np.concatenate([middle - half, middle + half]))
        for name, rows in labels_of(exported("yolo")).items()
        for row in rows
        for middle, half in [(scaled(row)[:2], 0.5 * scaled(row)[2:])]
    ]
    assert average_precision(true_boxes(), boxes) == pytest.approx(1.0)
    shifted = [(name, kind, box + 2.0) for name, kind, box in boxes]
    assert average_precision(true_boxes(), shifted) < 0.9


def test_outlines_are_the_pixels_that_are_seen(exported: Callable[[str], Path]) -> None:
    labels = labels_of(exported("yolo-seg"))
    assert len(labels) == 2 * FRAMES
    for name, rows in labels.items():
        truth = truths()[int(name[-6:])]
        shown = [k for k in IDS if (truth.instance_map == k).any()]
        assert len(rows) == len(shown)
        for row in rows:
            mask = truth.instance_map == IDS[KINDS.index(("bus", "car", "kite")[int(row[0])])]
            back = filled(row[1:].reshape(-1, 2) * (WIDTH_PX, HEIGHT_PX), HEIGHT_PX, WIDTH_PX)
            np.testing.assert_array_equal(back, mask)


@pytest.mark.parametrize("name", ["yolo-obb", "dota"])
def test_oriented_boxes_of_upright_objects_are_their_boxes(exported: Callable[[str], Path], name: str) -> None:
    found, out = [], exported(name)
    if name == "dota":
        for file in sorted(out.glob("*/labelTxt/*.txt")):
            assert (out / file.parts[-3] / "images" / f"{file.stem}.png").is_file()
            heading, gsd, *lines = file.read_text().splitlines()
            assert (heading.split(":")[0], gsd) == ("imagesource", "gsd:null")
            for *numbers, kind, difficult in map(str.split, lines):
                assert difficult == "0"
                corners = np.array(numbers, float).reshape(4, 2)
                found.append((file.stem, ("bus", "car", "kite").index(kind), around(corners)))
    else:
        for stem, rows in labels_of(out).items():
            found += [(stem, int(row[0]), around(row[1:].reshape(4, 2) * (WIDTH_PX, HEIGHT_PX))) for row in rows]
    assert average_precision(true_boxes(), found) == pytest.approx(1.0)


def test_what_is_ignored_is_difficult_in_dota_and_left_out_of_yolo(data: DataSet, tmp_path: Path) -> None:
    few = export(data, "dota", tmp_path / "dota", min_size_px=4)
    lines = [line for file in (tmp_path / "dota").rglob("labelTxt/*") for line in file.read_text().splitlines()[2:]]
    assert few == sum(line.endswith(" 1") for line in lines) > 0
    for name in ("yolo-seg", "yolo-obb"):
        assert export(data, name, tmp_path / name, min_size_px=4) == few
        assert sum(map(len, labels_of(tmp_path / name).values())) == len(lines) - few
