"""Results of COCO and TAO: pycocotools takes the same files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.coco_json import NO_TRACK, read_annotations, read_json, read_results

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
    said = read_annotations(annotations)
    assert said is not None
    assert said.folders == {"a": {"000003.png": 3, "000008.png": 8}}
    assert said.images == images
    assert said.categories == {1: "car"}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('[\n{"image_id": 3,}]', r"r\.json, line 2: expected JSON, got"),
        ({"image_id": 3}, r"r\.json: expected a list of results"),
        ([_ENTRY, 5], r"r\.json, entry 2: expected an entry with image_id"),
        ([_ENTRY | {"image_id": "x"}], "entry 1: expected a whole number as image_id, got 'x'"),
        ([_ENTRY | {"bbox": [1, 2, 3]}], "entry 1: expected left, top, width, height with .* >= 0 as bbox"),
        ([_ENTRY | {"bbox": [1, 2, -3, 4]}], "entry 1: expected left, top, width, height with .* >= 0 as bbox"),
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
    said = read_annotations(_written(tmp_path / "a.json", {"images": images}))
    assert said is not None
    assert said.folders == {"a": {"0.png": 1}, "": {"1.png": 2, "": 3}}


@pytest.mark.parametrize("content", [[], {}, {"images": "a"}])
def test_other_files_are_no_annotations(tmp_path: Path, content: Any) -> None:
    assert read_annotations(_written(tmp_path / "a.json", content)) is None


_IMAGE = {"id": 1, "file_name": "a/0.png"}


@pytest.mark.parametrize(
    "content",
    [
        {"images": [{"id": 1}]},
        {"images": ["a"]},
        {"images": [_IMAGE | {"video_id": [1]}]},
        {"images": [_IMAGE], "videos": [{"id": "x", "name": "a"}]},
        {"images": [_IMAGE], "annotations": [{"image_id": 1, "bbox": [1, 2, 10**400, 4]}]},
        {"images": [_IMAGE], "annotations": [{"image_id": 1, "bbox": [1, 2, "x", 4]}]},
        {"images": [_IMAGE], "annotations": [{"image_id": 1, "bbox": [1, 2, 3, 4], "visibility": None}]},
        {"images": [_IMAGE], "annotations": [{"image_id": {}, "bbox": [1, 2, 3, 4]}]},
    ],
)
def test_an_entry_that_lacks_something_is_named(tmp_path: Path, content: Any) -> None:
    with pytest.raises(ValueError, match=r"a\.json, (images|videos|annotations), entry 1: expected"):
        read_annotations(_written(tmp_path / "a.json", content)).boxes  # type: ignore[union-attr]  # noqa: B018


@pytest.mark.parametrize("text", [b"[" * 100_000, b"[" + b"1" * 5000 + b"]", b"[\xff]"])
def test_what_python_cannot_hold_is_no_json(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(text)
    with pytest.raises(ValueError, match=r"a\.json.*: expected JSON, got"):
        read_json(path)
