"""The tracker on drawn pictures."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.correlation_filter.textures import picture
from trackers.kernels.boxes import intersections_over_union
from trackers.registry import entry
from trackers.types import CameraModel, Observation

SIZE = np.array([26.0, 18.0])


@pytest.mark.parametrize("is_grey", [False, True])
def test_it_follows_a_target_that_moves_and_grows(is_grey: bool) -> None:
    tracker = entry("correlation_filter").create(np.random.default_rng(0))
    camera = CameraModel(200, 160, 240.0)
    overlaps = []
    for k in range(25):
        centre, scale = np.array([70 + 2.4 * k, 60 + 1.5 * k]), 1.01**k
        image_rgb = picture((centre[0], centre[1]), (SIZE[0], SIZE[1]), scale=scale)
        if is_grey:
            image_rgb = np.repeat(image_rgb.mean(-1, keepdims=True), 3, axis=-1).astype(np.uint8)
        observation = Observation(image_rgb, k / 30, camera)
        box = np.concatenate([centre - 0.5 * scale * SIZE, centre + 0.5 * scale * SIZE])
        if k == 0:
            tracker.initialise(observation, box)
        else:
            overlaps.append(intersections_over_union(tracker.update(observation).box_xyxy[None], box[None])[0, 0])
    assert min(overlaps) > 0.75
    assert np.mean(overlaps) > 0.85


def test_it_waits_where_its_target_is_hidden_and_finds_it_again() -> None:
    tracker = entry("correlation_filter").create(np.random.default_rng(0))
    camera, size = CameraModel(200, 160, 240.0), (26.0, 18.0)
    box = np.array([87.0, 71.0, 113.0, 89.0])
    tracker.initialise(Observation(picture((100, 80), size), 0.0, camera), box)
    for k in range(1, 25):
        centre = (100 + min(k, 8) * 0.5, 80.0)
        estimate = tracker.update(Observation(picture(centre, size, is_hidden=8 < k < 20), k / 30, camera))
        assert np.abs(estimate.position_px - centre).max() < 1.5, k
        assert (estimate.in_view_probability > 0.5) == (not 8 < k < 20), k


@pytest.mark.parametrize("box_xyxy", [(70, 50, 94, 64), (-20, 40, 30, 70), (-40, -20, 200, 140)])
def test_flat_pictures_move_it_nowhere(box_xyxy: tuple[float, ...]) -> None:
    tracker = entry("correlation_filter").create(np.random.default_rng(0))
    flat, box = np.full((120, 160, 3), 90, np.uint8), np.array(box_xyxy, float)
    observation = Observation(flat, 0.0, CameraModel(160, 120, 200.0))
    tracker.initialise(observation, box)
    for _ in range(10):
        estimate = tracker.update(observation)
    np.testing.assert_allclose(estimate.box_xyxy, box)
