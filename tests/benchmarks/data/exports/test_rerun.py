"""Recordings for Rerun, read back with its own reader."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.exports.exporter import export
from benchmarks.data.exports.rerun import RECORDING
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.sets.hand_made import BASELINE_M, write_set
from tests.benchmarks.fake_episode import CAMERA, HEIGHT, WIDTH

FRAMES = 12


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    return write_set(tmp_path_factory.mktemp("set"), frames=FRAMES)


@pytest.fixture(scope="module")
def recording(data: DataSet, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str, int], Any]:
    """Entity, component and frame (-1: static) → value."""
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    out = tmp_path_factory.mktemp("rerun") / "out"
    export(data, "rerun", out, allow_incomplete=True)
    return values_of(out / RECORDING)


def values_of(path: Path) -> dict[tuple[str, str, int], Any]:
    from rerun.chunk import RrdReader

    found = {}
    for chunk in RrdReader(path).stream():
        rows = chunk.to_record_batch().to_pydict()
        frames = rows.get("frame", [-1] * chunk.num_rows)
        for name, values in rows.items():
            if ":" in name:
                for frame, value in zip(frames, values, strict=True):
                    if value is not None:
                        found[chunk.entity_path, name, frame] = value
    return found


def test_all_episodes_and_frames_are_in_it(recording: dict[tuple[str, str, int], Any]) -> None:
    assert {entity.split("/")[1] for entity, _, _ in recording} == {"seed-000000", "seed-000001"}
    assert {frame for _, _, frame in recording} == {-1, *range(FRAMES)}


def test_the_camera_is_where_it_was_and_sees_as_it_did(recording: dict[tuple[str, str, int], Any]) -> None:
    root = "/seed-000001/camera"
    (matrix,) = recording[f"{root}/picture", "Pinhole:image_from_camera", 3]
    # Columns follow each other.
    f = CAMERA.focal_px
    np.testing.assert_allclose(matrix, [f, 0, 0, 0, f, 0, WIDTH / 2, HEIGHT / 2, 1])
    np.testing.assert_allclose(recording[root, "Transform3D:translation", 3], [[0, 0, 0]])
    np.testing.assert_allclose(recording[f"{root}/right", "Transform3D:translation", 3], [[BASELINE_M, 0, 0]])


def test_boxes_are_those_of_the_truth(recording: dict[tuple[str, str, int], Any], data: DataSet) -> None:
    root = "/seed-000001/camera/picture/boxes"
    for frame in (0, 10):
        visible = data.episode(1).visible_boxes_of(frame)
        known = np.isfinite(visible).all(axis=1)
        middle, half = 0.5 * (visible[:, 2:] + visible[:, :2]), 0.5 * (visible[:, 2:] - visible[:, :2])
        np.testing.assert_allclose(recording[f"{root}/visible", "Boxes2D:centers", frame], middle[known])
        np.testing.assert_allclose(recording[f"{root}/visible", "Boxes2D:half_sizes", frame], half[known])
    assert recording[f"{root}/amodal", "Boxes2D:labels", 0] == ["target in"]
    assert recording[f"{root}/amodal", "Boxes2D:labels", 10] == ["traffic-1 in"]


def test_objects_stand_on_their_ground_points_without_those_that_are_absent(
    recording: dict[tuple[str, str, int], Any],
) -> None:
    entity = "/seed-000001/objects"
    assert recording[entity, "Boxes3D:labels", 0] == ["target"]
    assert recording[entity, "Boxes3D:labels", 6] == ["target", "traffic-1"]
    np.testing.assert_allclose(recording[entity, "Boxes3D:centers", 6], [[1, 2, 0.5 + 0.75], [-3, 0, 0.75]])
    np.testing.assert_allclose(recording[entity, "Boxes3D:half_sizes", 6], [[2.25, 0.9, 0.75]] * 2)


def test_pictures_and_maps_hold_their_values(recording: dict[tuple[str, str, int], Any], data: DataSet) -> None:
    import cv2

    root = "/seed-000001/camera/picture"
    frame = data.episode(1).frame(4)
    (png,) = recording[f"{root}/image_rgb", "EncodedImage:blob", 4]
    image = cv2.imdecode(np.array(png, np.uint8), cv2.IMREAD_COLOR_RGB)
    np.testing.assert_array_equal(image, frame.observation.image_rgb)
    depth = np.frombuffer(bytes(recording[f"{root}/depth_m", "DepthImage:buffer", 4][0]), np.float32)
    assert set(depth.reshape(HEIGHT, WIDTH)[:10].ravel()) == {0.0}
    assert set(depth.reshape(HEIGHT, WIDTH)[10:].ravel()) == {40.0}
    classes = np.frombuffer(bytes(recording[f"{root}/instance_map", "SegmentationImage:buffer", 4][0]), np.uint16)
    np.testing.assert_array_equal(classes.reshape(HEIGHT, WIDTH), np.where(frame.truth.instance_map == 7, 1, 0))
    counts = np.frombuffer(bytes(recording[f"{root}/counts", "Image:buffer", 4][0]), np.uint16)
    assert set(counts) == {3004}


def test_a_lost_picture_is_cleared(recording: dict[tuple[str, str, int], Any]) -> None:
    entity = "/seed-000001/camera/right/picture/right_rgb"
    for frame in range(FRAMES):
        kinds = {name.split(":")[0] for where, name, when in recording if where == entity and when == frame}
        assert kinds == {"Clear"} if frame % 3 == 0 else {"EncodedImage"}, frame


def test_two_recordings_hold_the_same(
    recording: dict[tuple[str, str, int], Any], data: DataSet, tmp_path: Path
) -> None:
    export(data, "rerun", tmp_path / "again", allow_incomplete=True)
    assert values_of(tmp_path / "again" / RECORDING) == recording


def test_coded_pictures_are_passed_on_as_they_are(tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    data = write_set(tmp_path / "set", ("image_rgb",), frames=1, pictures="jpeg")
    export(data, "rerun", tmp_path / "a", allow_incomplete=True)
    entity = "/seed-000000/camera/picture/image_rgb"
    found = values_of(tmp_path / "a" / RECORDING)
    coded = data.episode(0).coded(0, "image_rgb")
    assert coded is not None
    assert bytes(found[entity, "EncodedImage:blob", 0][0]) == coded[1]
    assert found[entity, "EncodedImage:media_type", 0] == ["image/jpeg"]
