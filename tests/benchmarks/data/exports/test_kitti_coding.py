"""16-bit maps, read back by the rules of KITTI's development kit."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.kitti_coding import distance_map, flow_map, write_png16


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


def test_distances_return_within_half_a_step(tmp_path: Path) -> None:
    values = np.random.default_rng(1).uniform(0.01, 255.99, (50, 60))
    values[0, :6] = [0.0, np.inf, np.nan, -3.0, 256.0, 1e-6]
    write_png16(distance_map(values), tmp_path / "a.png")
    read, valid = read_distance(tmp_path / "a.png")
    assert valid[0, :6].tolist() == [False, False, False, False, False, True]
    assert valid[1:].all()
    assert np.abs(read - values)[valid].max() <= 0.5 / 256 + 0.5 / 256 * (values[valid] < 0.002).any()
    assert np.abs(read - values)[1:].max() <= 0.5 / 256


def test_flow_returns_within_half_a_step(tmp_path: Path) -> None:
    flow = np.random.default_rng(2).uniform(-511.9, 511.9, (50, 60, 2))
    flow[0, :4] = [[np.nan, 0.0], [600.0, 0.0], [0.0, -513.0], [np.inf, np.inf]]
    write_png16(flow_map(flow), tmp_path / "a.png")
    read, valid = read_flow(tmp_path / "a.png")
    assert valid[0, :4].tolist() == [False] * 4
    assert valid[1:].all()
    assert np.abs(read - flow)[valid].max() <= 0.5 / 64


def test_what_is_not_valid_is_zero_throughout() -> None:
    assert (flow_map(np.full((2, 2, 2), np.nan)) == 0).all()
