"""Blobs on the ground: places, sizes, and what stands elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW
from trackers.baselines.ground_linker import Blob, BlobParameters, blobs_of
from trackers.site import placed

SITE = placed(SURVEY, CAMERA, VIEW.T_world_camera)
SHAPE = (CAMERA.height_px, CAMERA.width_px)


def box_of(place_m: tuple[float, float], width_m: float, height_m: float, base_m: float = 0.0) -> NDArray[np.int64]:
    """Return the box in the picture of a flat thing that stands at a place, at the height ``base_m``."""
    corners_m = np.array([[*place_m, base_m], [*place_m, base_m + height_m]]) + np.array(
        [[0, width_m / 2, 0], [0, -width_m / 2, 0]]
    )
    px, _ = VIEW.project(corners_m)
    return np.round([px[0, 0], px[1, 1], px[1, 0], px[0, 1]]).astype(int)


def found(*boxes: NDArray[np.int64], contrast: float = 8.0, **changes: float) -> list[Blob]:
    foreground = np.zeros(SHAPE, np.uint8)
    for x0, y0, x1, y1 in boxes:
        foreground[y0:y1, x0:x1] = 255
    parameters = BlobParameters(**changes)  # type: ignore[arg-type]
    return blobs_of(foreground, np.full(SHAPE, contrast, np.float32) * (foreground > 0), SITE, parameters)


@pytest.mark.parametrize(
    ("place_m", "base_m"), [((0.0, 0.0), 0.0), ((-10.0, 4.0), 0.0), ((30.0, -5.0), 0.0), ((-24.0, 4.0), -1.8)]
)
def test_a_blob_stands_half_its_width_behind_its_foot_with_its_size(
    place_m: tuple[float, float], base_m: float
) -> None:
    [blob] = found(box_of(place_m, 1.2, 1.7, base_m))
    # Half a pixel is up to 0.7 m along the line of sight here, and 0.09 m across it.
    assert abs(blob.place_m[0] - place_m[0] - 0.6) < 0.7
    assert abs(blob.place_m[1] - place_m[1]) < 0.1
    assert blob.place_m[2] == pytest.approx(base_m)
    np.testing.assert_allclose(blob.size_m, [1.2, 1.2, 1.7], atol=0.2)
    away_m = np.sqrt(np.diag(blob.covariance_m2))
    assert 3 * away_m[1] > abs(blob.place_m[1] - place_m[1])
    assert 3 * away_m[0] > abs(blob.place_m[0] - place_m[0] - 0.6)


def test_the_strength_is_that_of_a_matched_filter() -> None:
    box = box_of((0.0, 0.0), 1.0, 1.7)
    area = np.prod(box[2:] - box[:2])
    [blob] = found(box, contrast=5.0, closing_px=1)
    assert blob.strength == pytest.approx(5.0 * np.sqrt(area))


def test_what_stands_outside_the_volume_or_above_the_horizon_is_left_out() -> None:
    assert found(box_of((60.0, 0.0), 1.0, 1.7)) == []
    assert found(np.array([50, 0, 60, 3])) == []


def test_a_picture_that_differs_everywhere_has_no_blobs() -> None:
    whole = np.array([0, 0, CAMERA.width_px, CAMERA.height_px])
    assert found(whole) == []
    assert found() == []


def test_a_gap_in_a_body_is_closed() -> None:
    box = box_of((0.0, 0.0), 0.8, 1.8)
    middle = (box[1] + box[3]) // 2
    legs, head = box.copy(), box.copy()
    legs[1], head[3] = middle + 1, middle - 1
    assert len(found(legs, head, closing_px=1)) == 2
    assert len(found(legs, head, closing_px=5)) == 1
