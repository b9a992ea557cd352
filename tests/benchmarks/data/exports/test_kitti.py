"""KITTI exports against the stored truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import export
from benchmarks.data.exports.kitti import distance_map, flow_map
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.forward_flow import forward_flow
from tests.benchmarks.data.exports.painted_scene import FOCAL_PX, FRAMES, painted_data_set, picture, truths


def samples(out: Path) -> list[tuple[str, int, int]]:
    """Return number, seed and frame of all samples."""
    heading, *lines = (out / "frames.csv").read_text().splitlines()
    assert heading == "number,seed,frame"
    parts = [line.split(",") for line in lines]
    return [(number, int(seed), int(frame)) for number, seed, frame in parts]


def test_depth_is_the_truth_within_half_a_step(exported: Callable[[str], Path]) -> None:
    out = exported("kitti-depth")
    assert len(samples(out)) == 2 * FRAMES
    for number, _, frame in samples(out):
        depth_m, valid = read_distance(out / "training" / "depth" / f"{number}_10.png")
        truth = truths()[frame].depth_m
        np.testing.assert_array_equal(valid, np.isfinite(truth))
        assert np.abs(depth_m - truth)[valid].max() <= 0.5 / 256


def test_disparity_times_depth_is_focal_length_times_baseline(exported: Callable[[str], Path]) -> None:
    out = exported("kitti-stereo")
    for number, _, frame in samples(out):
        disparity_px, valid = read_distance(out / "training" / "disp_occ_0" / f"{number}_10.png")
        truth = truths()[frame].depth_m
        np.testing.assert_array_equal(valid, np.isfinite(truth))
        assert np.abs(disparity_px - FOCAL_PX * 0.5 / truth)[valid].max() <= 0.5 / 256
        lines = (out / "training" / "calib_cam_to_cam" / f"{number}.txt").read_text().splitlines()
        left, right = (np.array(line.split(": ")[1].split(), float).reshape(3, 4) for line in lines)
        # A point's columns differ by its disparity.
        point = np.array([0.3, -0.2, 5.0, 1.0])
        columns = [(p @ point)[0] / (p @ point)[2] for p in (left, right)]
        assert columns[0] - columns[1] == pytest.approx(FOCAL_PX * 0.5 / 5.0)
        assert left[0, 2] == 19.5
        for folder in ("image_2", "image_3"):
            assert (out / "training" / folder / f"{number}_10.png").is_file()


def test_flow_leads_from_a_picture_to_the_previous_one(exported: Callable[[str], Path]) -> None:
    out = exported("kitti-flow")
    assert [frame for _, _, frame in samples(out)] == [*range(1, FRAMES)] * 2
    for number, seed, frame in samples(out):
        flow_px, valid = read_flow(out / "training" / "flow_occ" / f"{number}_10.png")
        truth = truths()[frame].flow_px
        np.testing.assert_array_equal(valid, np.isfinite(truth[..., 0]))
        assert np.abs(flow_px - truth)[valid].max() <= 0.5 / 64
        for suffix, back in (("10", 0), ("11", 1)):
            found = cv2.imread(str(out / "training" / "image_2" / f"{number}_{suffix}.png"))
            np.testing.assert_array_equal(found[..., ::-1], picture(seed, frame - back))
    assert "BACKWARD" in (out / "README.md").read_text()


def test_a_frame_whose_right_picture_was_lost_is_left_out(tmp_path: Path) -> None:
    export(painted_data_set(tmp_path / "set", "lossy", (3, 4)), "kitti-stereo", tmp_path / "out")
    assert [frame for _, _, frame in samples(tmp_path / "out")] == [k for k in range(FRAMES) if k != 3]


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", "single", (3, 4))
    with pytest.raises(
        ValueError, match="data: expected the channels image_rgb, right_rgb, depth_m for kitti-stereo, got"
    ):
        export(data, "kitti-stereo", tmp_path / "out")


def read_distance(path: Path) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return values and validity: value / 256 where it is not 0."""
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert stored.dtype == np.uint16
    return stored / 256.0, stored > 0


def read_flow(path: Path) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return flow and validity: (red or green - 2^15) / 64 where blue is not 0."""
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., ::-1]
    assert stored.dtype == np.uint16
    return (stored[..., :2].astype(float) - 2**15) / 64.0, stored[..., 2] > 0


def test_maps_round_to_half_a_step_and_are_zero_where_they_cannot_hold_a_value() -> None:
    rng = np.random.default_rng(1)
    values, flow = rng.uniform(0.01, 255.99, (50, 60)), rng.uniform(-511.9, 511.9, (50, 60, 2))
    assert np.abs(distance_map(values) / 256 - values).max() <= 0.5 / 256
    assert distance_map(np.array([[0.0, np.inf, np.nan, -3.0, 256.0, 1e-6]])).tolist() == [[0, 0, 0, 0, 0, 1]]
    for each in (flow, flow.astype(np.float32)):
        assert np.abs((flow_map(each)[..., :2] - 2.0**15) / 64 - each.astype(float)).max() <= 0.5 / 64
    assert (flow_map(flow)[..., 2] == 1).all()
    assert not flow_map(np.array([[[np.nan, 0.0], [600.0, 0.0], [0.0, -513.0], [np.inf, np.inf]]])).any()


def test_forward_flow_leads_from_a_picture_to_the_next_one(data: DataSet, exported: Callable[[str], Path]) -> None:
    """What the flow itself is, ``test_forward_flow`` tests."""
    out = exported("kitti-forward-flow")
    assert [frame for _, _, frame in samples(out)] == [*range(FRAMES - 1)] * 2
    for number, seed, frame in samples(out):
        expected, seen_next = forward_flow(data.episode(seed), frame)
        for folder, known in (("flow_occ", np.isfinite(expected[..., 0])), ("flow_noc", seen_next)):
            flow_px, valid = read_flow(out / "training" / folder / f"{number}_10.png")
            np.testing.assert_array_equal(valid, known)
            assert np.abs(flow_px - expected)[valid].max() <= 0.5 / 64
        for suffix, ahead in (("10", 0), ("11", 1)):
            found = cv2.imread(str(out / "training" / "image_2" / f"{number}_{suffix}.png"))
            np.testing.assert_array_equal(found[..., ::-1], picture(seed, frame + ahead))


def test_flow_of_sintel_is_read_by_opencv(data: DataSet, exported: Callable[[str], Path]) -> None:
    training = exported("sintel-flow") / "training"
    for seed in (3, 4):
        scene = f"painted-v1-quick-{seed:06d}"
        assert len(list((training / "clean" / scene).iterdir())) == FRAMES
        assert len(list((training / "flow" / scene).iterdir())) == FRAMES - 1
        for frame in range(FRAMES - 1):
            name = f"{scene}/frame_{frame + 1:04d}"
            flow_px = cv2.readOpticalFlow(str(training / "flow" / f"{name}.flo"))
            invalid, occluded = (
                cv2.imread(str(training / folder / f"{name}.png"), cv2.IMREAD_UNCHANGED) > 0
                for folder in ("invalid", "occlusions")
            )
            expected, seen_next = forward_flow(data.episode(seed), frame)
            np.testing.assert_array_equal(invalid, np.isnan(expected[..., 0]))
            np.testing.assert_array_equal(flow_px[~invalid], expected[~invalid])
            assert (flow_px[invalid] > 1e9).all()
            np.testing.assert_array_equal(occluded, ~seen_next & ~invalid)
