"""In view means a centre in the picture and a box that is long enough."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.visibility import centring, is_in_view, length_px
from trackers.types import CameraModel

CAMERA = CameraModel(200, 100, 100.0)
TARGET = 1


def truth(x: float, y: float, length: float = 20.0) -> Any:
    box = np.array([[0.0, 0.0, 1.0, 1.0], [x - length / 2, y - 1, x + length / 2, y + 1]])
    return SimpleNamespace(position_px=np.array([[0.0, 0.0], [x, y]]), box_xyxy=box)


@pytest.mark.parametrize(("x", "y", "p"), [(100, 50, 1.0), (150, 50, 0.5), (100, 75, 0.5), (200, 50, 0), (90, 120, 0)])
def test_centring_falls_to_the_border(x: float, y: float, p: float) -> None:
    assert centring(truth(x, y), TARGET, CAMERA) == pytest.approx(p)


@given(st.floats(-300, 500), st.floats(-300, 500))
def test_centring_is_by_the_ray_to_the_border(x: float, y: float) -> None:
    offset = np.array([x - 100.0, y - 50.0])
    # The ray meets the border where the larger of both shares is one.
    if np.abs(offset).max() < 1e-6:
        return
    scale = min(100.0 / max(abs(offset[0]), 1e-12), 50.0 / max(abs(offset[1]), 1e-12))
    wanted = max(1.0 - np.hypot(*offset) / np.hypot(*(offset * scale)), 0.0)
    assert centring(truth(x, y), TARGET, CAMERA) == pytest.approx(wanted, abs=1e-9)


def test_small_or_outside_is_not_in_view() -> None:
    assert is_in_view(truth(100, 50), TARGET, CAMERA)
    assert is_in_view(truth(199, 50), TARGET, CAMERA)
    assert not is_in_view(truth(201, 50), TARGET, CAMERA)
    assert length_px(truth(100, 50, length=11.9), TARGET) == pytest.approx(11.9)


@pytest.mark.parametrize(("width_px", "shortest_px"), [(84, 3.15), (200, 7.5), (320, 12.0), (640, 12.0), (1920, 12.0)])
def test_small_pictures_ask_for_the_same_share_and_large_ones_for_the_same_pixels(
    width_px: int, shortest_px: float
) -> None:
    camera = CameraModel(width_px, 100, 100.0)
    assert is_in_view(truth(0.5 * width_px, 50, length=shortest_px + 0.01), TARGET, camera)
    assert not is_in_view(truth(0.5 * width_px, 50, length=shortest_px - 0.01), TARGET, camera)


def test_behind_the_camera_is_nowhere() -> None:
    behind = truth(np.nan, np.nan)
    assert centring(behind, TARGET, CAMERA) == 0.0
    assert length_px(behind, TARGET) == 0.0
    assert not is_in_view(behind, TARGET, CAMERA)
