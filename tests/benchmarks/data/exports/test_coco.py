"""COCO exports, read and scored by pycocotools."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.data.exports.coco import write_json
from tests.benchmarks.data.exports.painted_scene import IDS, KINDS, picture, truths

# pycocotools decodes masks in the way of NumPy 1.
pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept:DeprecationWarning")
coco = pytest.importorskip("pycocotools.coco")
cocoeval = pytest.importorskip("pycocotools.cocoeval")


@pytest.fixture(scope="module")
def read(exported: Callable[[str], Path]) -> Any:
    with contextlib.redirect_stdout(io.StringIO()):
        return coco.COCO(str(exported("coco") / "annotations" / "instances.json"))


def average_precision(read: Any, kind: str, moved_px: float) -> float:
    found = [
        {**{k: each[k] for k in ("image_id", "category_id", "segmentation")}, "bbox": list(each["bbox"]), "score": 1.0}
        for each in read.dataset["annotations"]
    ]
    for each in found:
        each["bbox"][0] += moved_px
        if kind == "bbox":
            del each["segmentation"]
    with contextlib.redirect_stdout(io.StringIO()):
        scores = cocoeval.COCOeval(read, read.loadRes(found), kind)
        scores.evaluate()
        scores.accumulate()
        scores.summarize()
    return float(scores.stats[0])


@pytest.mark.parametrize("kind", ["bbox", "segm"])
def test_truth_against_itself_is_perfect(read: Any, kind: str) -> None:
    assert average_precision(read, kind, 0.0) == pytest.approx(1.0)


def test_moved_boxes_are_worse(read: Any) -> None:
    assert average_precision(read, "bbox", 1.0) < 0.9


def test_masks_are_the_pixels_of_the_instance_map(read: Any) -> None:
    frames = truths()
    names = {each["id"]: each["name"] for each in read.dataset["categories"]}
    shown = 0
    for image in read.dataset["images"]:
        truth = frames[int(Path(image["file_name"]).stem)]
        for annotation in read.loadAnns(read.getAnnIds(image["id"])):
            k = KINDS.index(names[annotation["category_id"]])
            mask = truth.instance_map == IDS[k]
            np.testing.assert_array_equal(read.annToMask(annotation), mask)
            assert annotation["area"] == mask.sum()
            x, y, width, height = map(int, annotation["bbox"])
            assert mask[y : y + height, x : x + width].any(axis=0).all()
            assert mask.sum() == mask[y : y + height, x : x + width].sum()
            shown += 1
    assert shown == 2 * sum(int((truth.instance_map == number).any()) for truth in frames for number in IDS)


def test_pictures_are_those_of_the_frames(read: Any, exported: Callable[[str], Path]) -> None:
    assert len(read.dataset["images"]) == 2 * len(truths())
    for image in read.dataset["images"]:
        sequence, frame = Path(image["file_name"]).with_suffix("").parts
        assert sequence[:-6] == "painted-v1-quick-"
        found = cv2.imread(str(exported("coco") / "images" / image["file_name"]))
        assert found.shape[:2] == (image["height"], image["width"])
        np.testing.assert_array_equal(found[..., ::-1], picture(int(sequence[-6:]), int(frame)))


def test_lists_come_together(tmp_path: Path) -> None:
    lists = {"two": ['{"k":0}', '{"k":1}'], "none": []}
    write_json(tmp_path / "a.json", {"info": {"é": None}}, lists)
    assert json.loads((tmp_path / "a.json").read_text()) == {
        "info": {"é": None},
        "two": [{"k": 0}, {"k": 1}],
        "none": [],
    }
