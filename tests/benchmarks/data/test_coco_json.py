"""Results of COCO and TAO: pycocotools takes the same files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.coco_json import NO_TRACK, read_pictures, read_results

_ENTRY = {"image_id": 3, "category_id": 1, "bbox": [10.5, 20, 4, 6], "score": 0.5}


def _written(path: Path, content: Any) -> Path:
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_pycocotools_reads_the_same_results(tmp_path: Path) -> None:
    coco = pytest.importorskip("pycocotools.coco")
    images = [{"id": number, "file_name": f"a/{number:06d}.png"} for number in (3, 8)]
    head = {"images": images, "annotations": [], "categories": [{"id": 1, "name": "car"}], "info": {}}
    annotations = _written(tmp_path / "instances.json", head)
    path = _written(tmp_path / "results.json", [_ENTRY, _ENTRY | {"image_id": 8, "score": 1, "track_id": 5}])
    read, theirs = read_results(path), coco.COCO(annotations).loadRes(str(path)).dataset["annotations"]
    assert read.image_id.tolist() == [each["image_id"] for each in theirs]
    assert read.score.tolist() == [each["score"] for each in theirs]
    width_height = read.box_xyxy[:, 2:] - read.box_xyxy[:, :2]
    np.testing.assert_allclose(np.column_stack([read.box_xyxy[:, :2], width_height]), [each["bbox"] for each in theirs])
    assert read.track_id.tolist() == [NO_TRACK, 5]
    assert read_pictures(annotations).folders == {"a": {"000003.png": 3, "000008.png": 8}}
    assert read_pictures(annotations).file_names == {3: "a/000003.png", 8: "a/000008.png"}
    assert read_pictures(annotations).categories == {1: "car"}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('[\n{"image_id": 3,}]', r"r\.json, line 2: expected JSON, got"),
        ({"image_id": 3}, r"r\.json: expected a list of results"),
        ([_ENTRY, 5], r"r\.json, entry 2: expected a result such as"),
        ([_ENTRY | {"image_id": "x"}], "entry 1: expected a whole number as image_id, got 'x'"),
        ([_ENTRY | {"bbox": [1, 2, 3]}], "entry 1: expected left, top, width, height as bbox"),
        ([_ENTRY | {"bbox": [1, 2, -3, 4]}], "entry 1: expected left, top, width, height as bbox"),
        ('[{"image_id": 1, "category_id": 1, "bbox": [NaN, 1, 1, 1], "score": 1}]', "as bbox"),
        ([_ENTRY | {"score": None}], "entry 1: expected a number as score, got None"),
        ([_ENTRY | {"track_id": -7}], "entry 1: expected a whole number >= 0 as track_id"),
    ],
)
def test_a_wrong_entry_is_named(tmp_path: Path, content: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_results(_written(tmp_path / "r.json", content))


def test_pictures_may_lie_deep_or_in_no_folder(tmp_path: Path) -> None:
    names = {1: "val/a/0.png", 2: "1.png", 3: ""}
    images = [{"id": number, "file_name": name} for number, name in names.items()]
    assert read_pictures(_written(tmp_path / "a.json", {"images": images})).folders == {
        "a": {"0.png": 1},
        "": {"1.png": 2, "": 3},
    }


@pytest.mark.parametrize("content", [[], {}, {"images": [{"id": 1}]}, {"images": ["a"]}])
def test_other_files_are_no_annotations(tmp_path: Path, content: Any) -> None:
    with pytest.raises(ValueError, match=r'a\.json.*: expected annotations with "images"'):
        read_pictures(_written(tmp_path / "a.json", content))
