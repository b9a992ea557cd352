"""COCO exports, read and scored by pycocotools; TAO-Amodal exports, by the rules that its evaluation applies."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks.data.exports.coco import TaoAmodal, write_json
from benchmarks.data.exports.exporter import export
from benchmarks.data.exports.labels import Labels
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.exports.painted_scene import (
    HEIGHT_PX,
    IDS,
    KINDS,
    WIDTH_PX,
    painted_data_set,
    picture,
    truths,
)

# pycocotools decodes masks in the way of NumPy 1.
pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept:DeprecationWarning")
coco = pytest.importorskip("pycocotools.coco")
cocoeval = pytest.importorskip("pycocotools.cocoeval")


@pytest.fixture(scope="module")
def read(exported: Callable[[str], Path]) -> Any:
    return opened(exported("coco") / "annotations" / "instances.json")


def opened(file: Path) -> Any:
    with contextlib.redirect_stdout(io.StringIO()):
        return coco.COCO(str(file))


def average_precision(read: Any, kind: str, moved_px: float) -> float:
    found = [
        {k: each[k] for k in ("image_id", "category_id", *(["segmentation"] if kind == "segm" else []))}
        | {"bbox": [each["bbox"][0] + moved_px, *each["bbox"][1:]], "score": 1.0}
        for each in read.dataset["annotations"]
    ]
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


def test_a_set_with_shares_has_a_file_for_each_split(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 4))
    data.request = replace(data.request, splits={"train": 0.5, "val": 0.5})
    for name, file in (("coco", "instances"), ("coco-keypoints", "person_keypoints")):
        export(data, name, tmp_path / name)
        annotations = tmp_path / name / "annotations"
        assert {path.name for path in annotations.iterdir()} == {f"{file}_train.json", f"{file}_val.json"}
        for split, seeds in data.splits.items():
            read = opened(annotations / f"{file}_{split}.json")
            pictures = [each["file_name"] for each in read.dataset["images"]]
            frames = range(len(truths()))
            assert pictures == [f"painted-v1-quick-{seed:06d}/{k:06d}.png" for seed in seeds for k in frames]
            assert [each["id"] for each in read.dataset["images"]] == [*range(1, len(pictures) + 1)]
            assert average_precision(read, "bbox", 0.0) == pytest.approx(1.0)


def test_lists_come_together(tmp_path: Path) -> None:
    lists = {"two": ['{"k":0}', '{"k":1}'], "none": []}
    write_json(tmp_path / "a.json", {"info": {"é": None}}, lists)
    assert json.loads((tmp_path / "a.json").read_text()) == {
        "info": {"é": None},
        "two": [{"k": 0}, {"k": 1}],
        "none": [],
    }


@pytest.fixture(scope="module")
def tao(exported: Callable[[str], Path]) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((exported("tao-amodal") / "amodal_annotations" / "validation.json").read_text())
    return loaded


def test_lists_refer_to_each_other(tao: dict[str, Any], exported: Callable[[str], Path]) -> None:
    by_id = {name: {each["id"]: each for each in tao[name]} for name in ("videos", "images", "tracks", "categories")}
    assert all(len(by_id[name]) == len(tao[name]) for name in by_id)
    assert len({each["id"] for each in tao["annotations"]}) == len(tao["annotations"])
    for annotation in tao["annotations"]:
        track, image = by_id["tracks"][annotation["track_id"]], by_id["images"][annotation["image_id"]]
        assert annotation["category_id"] == track["category_id"]
        assert annotation["video_id"] == track["video_id"] == image["video_id"]
        assert annotation["category_id"] in by_id["categories"]
    for image in tao["images"]:
        assert image["video"] == by_id["videos"][image["video_id"]]["name"]
        assert (exported("tao-amodal") / "frames" / image["file_name"]).is_file()
    assert len(tao["videos"]) == 2
    assert len(tao["tracks"]) == 6
    assert all(video["neg_category_ids"] == [] for video in tao["videos"])


def test_annotations_are_the_truth(tao: dict[str, Any]) -> None:
    kinds = {each["id"]: each["name"] for each in tao["categories"]}
    images = {each["id"]: each for each in tao["images"]}
    hidden = outside = 0
    for annotation in tao["annotations"]:
        truth = truths()[images[annotation["image_id"]]["frame_index"]]
        k = KINDS.index(kinds[annotation["category_id"]])
        x, y, width, height = annotation["amodal_bbox"]
        np.testing.assert_allclose([x, y, x + width, y + height], truth.box_xyxy[k])
        assert annotation["visibility"] == pytest.approx(truth.visible_fraction[k])
        assert annotation["out_of_frame"] == (x < 0 or y < 0 or x + width > WIDTH_PX or y + height > HEIGHT_PX)
        assert not annotation["amodal_is_uncertain"]
        if truth.visible_fraction[k] == 0:
            assert annotation["bbox"] == [0, 0, 0, 0]
            hidden += not annotation["out_of_frame"]
            outside += annotation["out_of_frame"]
        else:
            columns = np.flatnonzero((truth.instance_map == truth.instance_id[k]).any(axis=0))
            assert annotation["bbox"][0] == columns[0]
            assert annotation["bbox"][2] == columns[-1] - columns[0] + 1
            assert annotation["area"] == annotation["bbox"][2] * annotation["bbox"][3]
    assert hidden > 0
    assert outside > 0
    # Behind the camera, and not seen: no annotation.
    assert len(tao["annotations"]) == 2 * (3 * len(truths()) - 2)


def test_the_file_that_is_scored_has_amodal_boxes(tao: dict[str, Any], exported: Callable[[str], Path]) -> None:
    path = exported("tao-amodal") / "amodal_annotations" / "validation_lvis_v1.json"
    scored: dict[str, Any] = json.loads(path.read_text())
    assert scored["tracks"] == tao["tracks"]
    assert scored["videos"] == tao["videos"]
    for annotation, other in zip(scored["annotations"], tao["annotations"], strict=True):
        assert annotation["bbox"] == annotation["amodal_bbox"] == other["amodal_bbox"]
        assert annotation["area"] == pytest.approx(annotation["bbox"][2] * annotation["bbox"][3])
        assert annotation | {"bbox": other["bbox"], "area": other["area"]} == other
    assert {each["frequency"] for each in scored["categories"]} == {"f"}
    everything = {each["id"] for each in scored["categories"]}
    for image in scored["images"]:
        shown = {each["category_id"] for each in scored["annotations"] if each["image_id"] == image["id"]}
        assert set(image["neg_category_ids"]) == everything - shown
        assert image["not_exhaustive_category_ids"] == []
    # In two pictures of each episode an object is behind the camera.
    assert sum(bool(image["neg_category_ids"]) for image in scored["images"]) == 4


def test_a_seen_object_without_an_amodal_box_is_uncertain(
    data: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = TaoAmodal.frames

    def behind(*given: Any) -> Any:
        for stored in real(*given):
            boxes = stored.frame.truth.box_xyxy.copy()
            boxes[0] = np.nan
            frame = replace(stored.frame, truth=replace(stored.frame.truth, box_xyxy=boxes))
            yield replace(stored, frame=frame)

    monkeypatch.setattr(TaoAmodal, "frames", behind)
    TaoAmodal(data, tmp_path, Labels(data)).write()
    read = json.loads((tmp_path / "amodal_annotations" / "validation.json").read_text())
    uncertain = [each for each in read["annotations"] if each["amodal_is_uncertain"]]
    assert len(uncertain) == 2 * len(truths())
    assert all(each["amodal_bbox"] == each["bbox"] == [16, 8, 12, 16] for each in uncertain)
