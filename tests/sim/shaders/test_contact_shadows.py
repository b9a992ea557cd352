"""Where in a picture the ground may be darkened, against every pixel looked at."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.optics import PinholeCamera, look_down_pose, rays
from sim.render.triangles import camera_view
from sim.render.visibility import NEAR_M
from sim.shaders.contact_shadows import STEP_M, _columns_of

CAMERA = PinholeCamera.from_field_of_view(80, 60, np.radians(70))
COLUMNS, ROWS = np.meshgrid(np.arange(80), np.arange(60))
PIXELS = np.stack([COLUMNS, ROWS], axis=-1) + 0.5
ORIGIN_M = np.array([-4.0, -4.0])


@settings(max_examples=200, deadline=None)
@given(
    place=st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.3, 2.0)),
    yaw=st.floats(-3, 3),
    pitch=st.floats(0.0, 1.7),
    roll=st.floats(-0.3, 0.3),
    corner=st.tuples(st.integers(0, 80), st.integers(0, 80)),
    side=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    slope=st.sampled_from([0.0, 0.3, -0.5]),
)
def test_no_darkened_pixel_lies_outside_the_columns(place, yaw, pitch, roll, corner, side, slope):
    T_world_camera = look_down_pose(np.array(place), yaw, pitch, roll)
    changed = np.array([[corner[1], corner[1] + side[1], corner[0], corner[0] + side[0]]])
    # What spheres darkened, and the samples around it from which light is mixed.
    low_m = ORIGIN_M + STEP_M * (np.array(corner) - 1)
    high_m = ORIGIN_M + STEP_M * (np.array(corner) + side)
    heights_m = np.sort(slope * np.array([low_m[0], high_m[0]]))
    within = np.empty((CAMERA.height_px, 2), np.int32)
    _columns_of(changed, ORIGIN_M, heights_m, camera_view(CAMERA, T_world_camera, 0.5), CAMERA.width_px, within)
    # The ground z = slope x, where the rays through all pixels meet it.
    directions, eye_m = rays(CAMERA, T_world_camera, PIXELS), np.array(place)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth_m = (slope * eye_m[0] - eye_m[2]) / (directions[..., 2] - slope * directions[..., 0])
        ground_m = eye_m[:2] + depth_m[..., None] * directions[..., :2]
    is_dark = (depth_m >= NEAR_M) & ((ground_m > low_m) & (ground_m < high_m)).all(axis=-1)
    is_within = (within[ROWS, 0] <= COLUMNS) & (within[ROWS, 1] > COLUMNS)
    assert not (is_dark & ~is_within).any()


def test_the_columns_are_no_wider_than_a_box_needs_to_be():
    T_world_camera = look_down_pose(np.array([0.0, 0.0, 4.0]), 0.0, 0.0, 0.0)
    within = np.empty((CAMERA.height_px, 2), np.int32)
    view = camera_view(CAMERA, T_world_camera, 0.5)
    _columns_of(np.array([[45, 55, 45, 55]]), ORIGIN_M, np.zeros(2), view, CAMERA.width_px, within)
    is_within = (within[ROWS, 0] <= COLUMNS) & (within[ROWS, 1] > COLUMNS)
    # A square of 11 samples, seen from 4 m.
    side_px = 11 * STEP_M * CAMERA.focal_px / 4.0
    assert side_px**2 <= is_within.sum() <= (side_px + 4) ** 2
    assert not is_within.all(axis=1).any()


def test_where_nobody_stands_no_column_is_looked_at():
    within = np.empty((CAMERA.height_px, 2), np.int32)
    view = camera_view(CAMERA, look_down_pose(np.array([0.0, 0.0, 4.0]), 0.0, 0.0, 0.0), 0.5)
    _columns_of(np.zeros((3, 4), np.int64), ORIGIN_M, np.zeros(2), view, CAMERA.width_px, within)
    assert (within[:, 0] >= within[:, 1]).all()
