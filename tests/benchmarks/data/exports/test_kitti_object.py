"""KITTI's 3-D labels, read by the rules of its devkit: 3-D boxes go through the calibration onto the 2-D boxes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.data.exports.exporter import export
from benchmarks.data.exports.kitti_object import calibration_lines, label_line, level_turn
from benchmarks.data.exports.labels import Instance
from benchmarks.data.sets.data_set import DataSet
from sim.optics import invert_pose, look_down_pose, project
from tests.benchmarks.data.exports.painted_scene import FRAMES, HEIGHT_PX, WIDTH_PX
from tests.benchmarks.data.exports.scoring import average_precision
from tests.benchmarks.data.exports.test_yolo import true_boxes
from trackers.types import CameraModel

CAMERA = CameraModel(400, 300, 350.0)


@dataclass
class Label:
    """A line, as the devkit's ``readLabels.m`` has it."""

    type: str
    truncation: float
    occlusion: int
    alpha: float
    box: NDArray[np.float64]
    h: float
    w: float
    l: float  # noqa: E741
    t: NDArray[np.float64]
    ry: float


def read_label(line: str) -> Label:
    cells = line.split(" ")
    assert len(cells) == 15
    n = [float(cell) for cell in cells[1:]]
    return Label(cells[0], n[0], int(cells[2]), n[2], np.array(n[3:7]), n[7], n[8], n[9], np.array(n[10:13]), n[13])


def read_calibration(lines: list[str]) -> dict[str, NDArray[np.float64]]:
    entries = (line.split(": ") for line in lines)
    return {name: np.array(text.split(), float).reshape(3, -1) for name, text in entries}


def corners_px(label: Label, P: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners (8, 2) in the picture, as the devkit's ``computeBox3D.m`` does, in its own words."""
    R = np.array([[np.cos(label.ry), 0, np.sin(label.ry)], [0, 1, 0], [-np.sin(label.ry), 0, np.cos(label.ry)]])
    x = np.array([1, 1, -1, -1, 1, 1, -1, -1]) * label.l / 2
    y = np.array([0, 0, 0, 0, -1, -1, -1, -1]) * label.h
    z = np.array([1, -1, -1, 1, 1, -1, -1, 1]) * label.w / 2
    corners = R @ np.array([x, y, z]) + label.t[:, None]
    pixels = P @ np.vstack([corners, np.ones(8)])
    return (pixels[:2] / pixels[2]).T


def instance_at(T: NDArray[np.float64], points: NDArray[np.float64], T_world_camera: NDArray[np.float64]) -> Instance:
    """Return an object whose body are points (P, 3) in its own frame."""
    pixels, _ = project(CAMERA, T_world_camera, points @ T[:3, :3].T + T[:3, 3])
    box = np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
    bounds = np.array([points.min(axis=0), points.max(axis=0)])
    return Instance("target", "sedan", 0, 5, "in", box, box, 0.97, 0.0, T, bounds)


angles = st.floats(-np.pi, np.pi)


@given(angles, st.floats(0.0, 0.5 * np.pi), angles, st.floats(-0.2, 0.2), angles, st.integers(0, 99))
def test_a_3d_box_encloses_the_2d_box_of_any_camera(
    yaw: float, down: float, heading: float, rolls: float, where: float, seed: int
) -> None:
    """Level or straight down, upright or rolling: and of an upright object the box is its own."""
    rng = np.random.default_rng(seed)
    T_world_camera = np.eye(4)
    level = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    T_world_camera[:3, :3] = (
        Rotation.from_euler("z", yaw).as_matrix() @ level @ Rotation.from_euler("x", -down).as_matrix()
    )
    T_world_camera[:3, 3] = rng.uniform(-50, 50, 3)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("ZX", [heading, rolls]).as_matrix()
    T[:3, 3] = T_world_camera[:3, 3] + T_world_camera[:3, :3] @ (
        3 * np.cos(where),
        2 * np.sin(where),
        rng.uniform(9, 60),
    )
    points = rng.uniform((-2.2, -0.9, 0.0), (2.2, 0.9, 1.5), (60, 3))
    one = instance_at(T, points, T_world_camera)
    turn = level_turn(T_world_camera)
    label = read_label(label_line("car", CAMERA, one, turn, invert_pose(T_world_camera) @ T))
    calibration = read_calibration(calibration_lines(CAMERA, turn))
    seen = corners_px(label, calibration["P2"]) + 0.5
    assert (seen.min(axis=0) <= one.box_xyxy[:2] + 1e-2).all()
    assert (seen.max(axis=0) >= one.box_xyxy[2:] - 1e-2).all()
    # The level frame's y is straight down in the world.
    np.testing.assert_allclose(T_world_camera[:3, :3] @ calibration["R0_rect"].T @ (0, 1, 0), (0, 0, -1), atol=1e-9)
    ahead_of_velodyne = calibration["R0_rect"] @ calibration["Tr_velo_to_cam"] @ (1, 0, 0, 1)
    np.testing.assert_allclose(ahead_of_velodyne, (0, 0, 1), atol=1e-9)
    azimuth = np.arctan2(label.t[0], label.t[2])
    assert np.cos(label.ry - azimuth - label.alpha) == pytest.approx(1.0)
    if abs(rolls) < 1e-9:
        np.testing.assert_allclose([label.l, label.w, label.h], np.ptp(points, axis=0), atol=1e-5)
    else:
        assert label.h * label.w >= np.prod(np.ptp(points, axis=0)[1:]) - 1e-4


def test_a_car_seen_from_straight_above_has_its_heading_and_place() -> None:
    """It drives to the picture's right: rotation_y is 0; to its upper edge, which is ahead: -pi / 2."""
    T_world_camera = look_down_pose(np.array([10.0, 20.0, 60.0]), 0.3, 0.0, 0.0)
    turn = level_turn(T_world_camera)
    body = np.array([[-2.0, -1.0, 0.0], [2.0, 1.0, 1.5]])
    for direction, expected in (((1, 0, 0), 0.0), ((0, -1, 0), -0.5 * np.pi), ((-1, 0, 0), np.pi)):
        ahead = T_world_camera[:3, :3] @ direction
        T = np.eye(4)
        T[:3, :3] = np.column_stack([ahead, np.cross((0, 0, 1), ahead), (0, 0, 1)])
        T[:3, 3] = (10.0, 20.0, 0.0)
        line = label_line("car", CAMERA, instance_at(T, body, T_world_camera), turn, invert_pose(T_world_camera) @ T)
        label = read_label(line)
        assert np.cos(label.ry - expected) == pytest.approx(1.0, abs=1e-9)
        np.testing.assert_allclose(label.t, (0, 60, 0), atol=1e-5)
        np.testing.assert_allclose([label.h, label.w, label.l], (1.5, 2, 4), atol=1e-5)


def test_truncation_and_occlusion_are_told() -> None:
    def line_of(box: tuple[float, ...], share: float) -> Label:
        xyxy, pose = np.array(box), np.eye(4)
        pose[:3, 3] = (0, 0, 10)
        seen = np.clip(np.where(np.isnan(xyxy), [0, 0, 50, 50], xyxy), 0, [400, 300, 400, 300])
        one = Instance("target", "sedan", 0, 5, "in", xyxy, seen, share, 0.0, pose, np.array([[-1.0] * 3, [1.0] * 3]))
        return read_label(label_line("car", CAMERA, one, np.eye(3), pose))

    half_out = line_of((350, 100, 450, 200), 0.5)
    assert (half_out.truncation, half_out.occlusion) == (0.5, 0)
    np.testing.assert_array_equal(half_out.box, [349.5, 99.5, 399, 199.5])
    assert [line_of((0, 0, 9, 9), share).occlusion for share in (1.0, 0.95, 0.94, 0.5, 0.49)] == [0, 0, 1, 1, 2]
    assert line_of((np.nan,) * 4, 0.0).occlusion == 3


def test_labels_are_the_truth_and_what_is_ignored_is_a_region(
    data: DataSet, exported: Callable[[str], Path], tmp_path: Path
) -> None:
    out = exported("kitti-object")
    samples = (out / "frames.csv").read_text().splitlines()[1:]
    assert len(samples) == 2 * FRAMES
    assert (out / "ImageSets" / "train.txt").read_text().split() == [f"{k:06d}" for k in range(2 * FRAMES)]
    found = []
    for sample in samples:
        number, seed, frame = sample.split(",")
        assert (out / "training" / "image_2" / f"{number}.png").is_file()
        assert "P2" in read_calibration((out / "training" / "calib" / f"{number}.txt").read_text().splitlines())
        for line in (out / "training" / "label_2" / f"{number}.txt").read_text().splitlines():
            label = read_label(line)
            kind = ("bus", "car", "kite").index(label.type)
            found.append((f"painted-v1-quick-{int(seed):06d}_{int(frame):06d}", kind, label.box))
    # What hides nothing and ends inside of the picture has the box of its pixels.
    kites = [each for each in true_boxes() if each[1] == 2]
    inset = [(name, kind, box - (0.5, 0.5, 0.5, 0.5)) for name, kind, box in kites]
    assert average_precision(inset, [each for each in found if each[1] == 2]) == pytest.approx(1.0)
    assert all((each[2] <= [WIDTH_PX - 1, HEIGHT_PX - 1] * 2).all() for each in found)
    few = export(data, "kitti-object", tmp_path / "out", min_size_px=4)
    texts = [file.read_text().splitlines() for file in (tmp_path / "out" / "training" / "label_2").iterdir()]
    regions = [label for lines in texts for label in map(read_label, lines) if label.type == "DontCare"]
    assert len(regions) == few > 0
    assert all((each.alpha, each.t.tolist(), each.ry) == (-10, [-1000] * 3, -10) for each in regions)


def test_a_scene_seen_through_water_is_refused(data: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenarios import catalog

    monkeypatch.setattr(catalog.scenario(data.request.scenario).truth, "pinhole", False)
    with pytest.raises(ValueError, match="data: expected a scene before a pinhole camera for kitti-object, got one"):
        export(data, "kitti-object", tmp_path / "out")
