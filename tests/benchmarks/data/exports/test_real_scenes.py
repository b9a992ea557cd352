"""Exports of the scenes themselves: 3-D boxes, named points and forward flow against what the pictures' truth says."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.data.exports.exporter import export
from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import write_episode
from benchmarks.data.sets.forward_flow import forward_flow
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import Request, existing_channels
from scenarios import catalog
from tests.benchmarks.data.exports.scoring import coco, evaluated
from tests.benchmarks.data.exports.test_kitti_object import corners_px, read_calibration, read_label

pytestmark = [
    pytest.mark.heavy,
    pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept:DeprecationWarning"),
]
PEOPLE, TOWN = catalog.scenario("stereo-follow").id, catalog.scenario("road-town").id
FISH, HARBOUR = catalog.scenario("fish-tank").id, catalog.scenario("harbour").id


@pytest.fixture(scope="module")
def sets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, DataSet]:
    """A few frames of each scene."""
    made = {}
    for scene in (PEOPLE, TOWN, FISH, HARBOUR):
        folder = tmp_path_factory.mktemp(scene) / "set"
        clip = "quick[frame_count=3,frame_outs.count=0]" if scene == TOWN else "quick[frame_count=3]"
        asked = Request(scene, clip, (1, 2), ())
        request = Request(scene, asked.preset, asked.seeds, existing_channels(asked))
        folder.mkdir()
        (folder / REQUEST).write_text(request.as_json())
        files, root = place_of(str(folder))
        write_episode(files, root, request, 1, request.episode(1))
        made[scene] = DataSet(str(folder))
    return made


@pytest.mark.parametrize("scene", [PEOPLE, TOWN, HARBOUR])
def test_3d_boxes_go_through_the_calibration_around_the_amodal_boxes(
    sets: dict[str, DataSet], tmp_path: Path, scene: str
) -> None:
    export(sets[scene], "kitti-object", tmp_path / "out")
    training, compared = tmp_path / "out" / "training", 0
    for file in (training / "label_2").iterdir():
        P = read_calibration((training / "calib" / file.name).read_text().splitlines())["P2"]
        for label in map(read_label, file.read_text().splitlines()):
            if label.occlusion < 3:
                seen = corners_px(label, P)
                assert (seen.min(axis=0) <= label.box[:2] + 0.01).all()
                assert (seen.max(axis=0) >= label.box[2:] - 0.01).all()
                compared += 1
    assert compared > 0 or scene == HARBOUR


@pytest.mark.parametrize("scene", [PEOPLE, FISH, HARBOUR])
def test_named_points_are_seen_where_the_object_is(sets: dict[str, DataSet], tmp_path: Path, scene: str) -> None:
    export(sets[scene], "coco-keypoints", tmp_path / "out")
    file = tmp_path / "out" / "annotations" / "person_keypoints.json"
    (category,) = json.loads(file.read_text())["categories"]
    with contextlib.redirect_stdout(io.StringIO()):
        read = coco.COCO(str(file))
    annotations = read.dataset["annotations"]
    if scene == HARBOUR and not annotations:
        return
    found = [{k: e[k] for k in ("image_id", "category_id", "keypoints")} | {"score": 1.0} for e in annotations]
    assert evaluated(read, found, "keypoints", category["sigmas"]) == pytest.approx(1.0)
    shown = 0
    for each in annotations:
        near = cv2.dilate(read.annToMask(each), np.ones((3, 3), np.uint8))
        for x, y, v in np.array(each["keypoints"]).reshape(-1, 3):
            if v == 2:
                assert near[int(y), int(x)]
                shown += 1
    assert shown > 0


def test_forward_flow_and_the_backward_flow_of_the_next_frame_are_opposite(sets: dict[str, DataSet]) -> None:
    """Where the next picture shows the point: both are exact, the second one read between four pixels."""
    episode = sets[TOWN].episode(1)
    for index in range(len(episode) - 1):
        flow_px, seen_next = forward_flow(episode, index)
        after = episode.frame(index + 1, ("flow_px",)).truth.flow_px
        height, width = seen_next.shape
        y, x = (np.mgrid[:height, :width] + flow_px.transpose(2, 0, 1)[::-1]).astype(np.float32)
        back_px = cv2.remap(after, x, y, cv2.INTER_LINEAR)
        away_px = np.linalg.norm(flow_px + back_px, axis=2)[seen_next]
        assert seen_next.mean() > 0.7
        assert np.median(away_px) < 0.01
        assert np.quantile(away_px[np.isfinite(away_px)], 0.97) < 0.2
