"""TAO-Amodal exports, by the rules that its reader and its evaluation apply."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.exports.coco import TaoAmodal
from benchmarks.data.exports.labels import Labels
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.exports.painted_scene import HEIGHT_PX, KINDS, WIDTH_PX, truths


@pytest.fixture(scope="module")
def read(exported: Callable[[str], Path]) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((exported("tao-amodal") / "amodal_annotations" / "validation.json").read_text())
    return loaded


def test_lists_refer_to_each_other(read: dict[str, Any], exported: Callable[[str], Path]) -> None:
    by_id = {name: {each["id"]: each for each in read[name]} for name in ("videos", "images", "tracks", "categories")}
    assert all(len(by_id[name]) == len(read[name]) for name in by_id)
    assert len({each["id"] for each in read["annotations"]}) == len(read["annotations"])
    for annotation in read["annotations"]:
        track, image = by_id["tracks"][annotation["track_id"]], by_id["images"][annotation["image_id"]]
        assert annotation["category_id"] == track["category_id"]
        assert annotation["video_id"] == track["video_id"] == image["video_id"]
        assert annotation["category_id"] in by_id["categories"]
    for image in read["images"]:
        assert image["video"] == by_id["videos"][image["video_id"]]["name"]
        assert (exported("tao-amodal") / "frames" / image["file_name"]).is_file()
    assert len(read["videos"]) == 2
    assert len(read["tracks"]) == 6
    assert all(video["neg_category_ids"] == [] for video in read["videos"])


def test_annotations_are_the_truth(read: dict[str, Any]) -> None:
    kinds = {each["id"]: each["name"] for each in read["categories"]}
    images = {each["id"]: each for each in read["images"]}
    hidden = outside = 0
    for annotation in read["annotations"]:
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
    assert len(read["annotations"]) == 2 * (3 * len(truths()) - 2)


def test_the_file_that_is_scored_has_amodal_boxes(read: dict[str, Any], exported: Callable[[str], Path]) -> None:
    path = exported("tao-amodal") / "amodal_annotations" / "validation_lvis_v1.json"
    scored: dict[str, Any] = json.loads(path.read_text())
    assert scored["tracks"] == read["tracks"]
    assert scored["videos"] == read["videos"]
    for annotation, other in zip(scored["annotations"], read["annotations"], strict=True):
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
