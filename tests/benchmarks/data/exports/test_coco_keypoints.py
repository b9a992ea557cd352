"""COCO's keypoints, read and scored by pycocotools."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.exports.coco_keypoints import visibilities
from benchmarks.data.exports.exporter import export
from benchmarks.data.sets.data_set import DataSet
from scenarios import catalog
from tests.benchmarks.data.exports.painted_scene import (
    IDS,
    PARKED_XYXY,
    WIDTH_PX,
    boxes_at,
    painted_data_set,
    points_px,
    truths,
)
from tests.benchmarks.data.exports.painted_scene import PAINTED as SCENE
from tests.benchmarks.data.exports.scoring import coco, evaluated

pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept:DeprecationWarning")


@pytest.fixture(scope="module")
def read(exported: Callable[[str], Path]) -> Any:
    with contextlib.redirect_stdout(io.StringIO()):
        return coco.COCO(str(exported("coco-keypoints") / "annotations" / "person_keypoints.json"))


def test_truth_against_itself_is_perfect_and_moved_points_are_worse(read: Any) -> None:
    (category,) = read.dataset["categories"]
    found = [
        {k: each[k] for k in ("image_id", "category_id", "keypoints")} | {"score": 1.0}
        for each in read.dataset["annotations"]
    ]
    assert evaluated(read, found, "keypoints", category["sigmas"]) == pytest.approx(1.0)
    moved = [each | {"keypoints": [v + 2 * (k % 3 == 0) for k, v in enumerate(each["keypoints"])]} for each in found]
    assert evaluated(read, moved, "keypoints", category["sigmas"]) < 0.9


def test_points_are_told_where_they_are_and_what_hides_them(read: Any) -> None:
    (category,) = read.dataset["categories"]
    assert (category["name"], category["keypoints"]) == ("car", ["rear", "middle", "front"])
    assert category["skeleton"] == [[1, 2], [2, 3]]
    told = set()
    assert len(read.dataset["annotations"]) == 2 * sum((t.instance_map == IDS[1]).any() for t in truths())
    for annotation in read.dataset["annotations"]:
        frame = int(Path(read.imgs[annotation["image_id"]]["file_name"]).stem)
        own = truths()[frame].instance_map == IDS[1]
        x, y, v = np.array(annotation["keypoints"]).reshape(-1, 3).T
        where = points_px(boxes_at(SCENE.presets["quick"], frame)[1])
        for k, (point_x, point_y, _) in enumerate(where):
            if point_x >= WIDTH_PX:
                assert (x[k], y[k], v[k]) == (0, 0, 0)
                continue
            assert (x[k], y[k]) == (pytest.approx(point_x), pytest.approx(point_y))
            near = own[int(point_y), max(int(point_x) - 1, 0) : int(point_x) + 2]
            assert v[k] == (2 if near.any() else 1)
            told.add(int(v[k]))
        assert annotation["num_keypoints"] == (v > 0).sum()
    assert told == {1, 2}


def test_who_stands_about_has_no_points_and_is_neither_missed_nor_wrong_to_find(tmp_path: Path) -> None:
    export(painted_data_set(tmp_path / "set", "parked", (3, 4)), "coco-keypoints", tmp_path / "out")
    with contextlib.redirect_stdout(io.StringIO()):
        read = coco.COCO(str(tmp_path / "out" / "annotations" / "person_keypoints.json"))
    everything = read.dataset["annotations"]
    parked = [each for each in everything if each["attributes"]["name"] == "parked-0"]
    assert len(parked) == len(truths())
    x_min, y_min, x_max, y_max = PARKED_XYXY.tolist()
    for each in parked:
        assert each["bbox"] == [x_min, y_min, x_max - x_min, y_max - y_min]
        assert (each["keypoints"], each["num_keypoints"], each["iscrowd"]) == ([0] * 9, 0, 1)
    points = [8.0, 28.0, 2] * 3
    found = [
        {"image_id": each["image_id"], "category_id": each["category_id"], "score": 1.0}
        | {"keypoints": points if each["iscrowd"] else each["keypoints"]}
        for each in everything
    ]
    (category,) = read.dataset["categories"]
    own = [each for each in found if each["keypoints"] is not points]
    for told in (found, own):
        assert evaluated(read, told, "keypoints", category["sigmas"]) == pytest.approx(1.0)
    # Without the annotation it would be wrong to find.
    read.dataset["annotations"] = [each for each in everything if not each["iscrowd"]]
    assert evaluated(read, found, "keypoints", category["sigmas"]) < 0.9


def test_a_point_is_seen_down_to_the_depth_of_the_limb() -> None:
    """Points in a body at 2 m: just inside, behind it, beside it by a pixel and by two, outside, behind the camera."""
    own = np.zeros((20, 30), bool)
    own[5:15, 5:15] = True
    depth_m = np.where(own, 2.0, 9.0).astype(np.float32)
    pixels = np.array([[10, 10], [10, 10], [15.5, 10], [16.5, 10], [30.0, 10], [np.nan, np.nan]])
    least_m = np.array([2.0, 2.01, 1.9, 1.9, 1.9, -1.0])
    assert visibilities(pixels, least_m, own, depth_m).tolist() == [2, 1, 2, 1, 0, 0]


def test_a_scene_without_named_points_is_refused(
    data: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(catalog.scenario(data.request.scenario).truth, "keypoints", {})
    with pytest.raises(ValueError, match="data: expected a scene whose objects have named points, for coco-keypoints"):
        export(data, "coco-keypoints", tmp_path / "out")
