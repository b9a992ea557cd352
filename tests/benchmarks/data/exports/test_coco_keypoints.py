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
from tests.benchmarks.data.exports.painted_scene import IDS, WIDTH_PX, boxes_at, points_px, truths
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
