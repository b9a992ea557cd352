"""PyBullet holds the poses that were given, draws what was added, and is let go."""

from __future__ import annotations

import gc
import sys

import numpy as np
import pybullet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim.mesh import Texture, TexturedMesh
from sim.optics import PinholeCamera, look_down_pose
from sim.world import World, _to_bullet


def square(side_m: float, rgb) -> TexturedMesh:
    corners = 0.5 * side_m * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32)
    return TexturedMesh(
        corners,
        np.tile(np.array([0, 0, 1], dtype=np.float32), (4, 1)),
        np.array([[0, 1], [1, 1], [1, 0], [0, 0]], dtype=np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32),
        Texture(np.full((4, 4, 3), rgb, dtype=np.uint8)),
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31))
def test_quaternion_is_scipys(seed):
    rotation = Rotation.random(rng=np.random.default_rng(seed))
    T = np.eye(4)
    T[:3, :3] = rotation.as_matrix()
    _, quaternion = _to_bullet(T)
    assert abs(np.dot(quaternion, rotation.as_quat())) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
def test_quaternion_of_half_turns(axis):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(np.pi * np.array(axis)).as_matrix()
    assert abs(np.dot(_to_bullet(T)[1][:3], axis)) == pytest.approx(1.0)


def test_moved_body_is_drawn_where_it_is_and_pybullet_agrees():
    with World() as world:
        world.add(square(40, (10, 200, 30)), np.eye(4), name="lawn", category="ground")
        car = world.add(square(4, (250, 0, 0)), np.eye(4), name="car", category="vehicle", movable=True)
        T = np.eye(4)
        T[:3, 3] = [6.0, -3.0, 1.0]
        world.move(car, T)
        np.testing.assert_array_equal(world.poses[car.index], T)
        camera = PinholeCamera.from_field_of_view(160, 120, 1.0)
        rgb, _, index = world.camera_image(camera, look_down_pose(np.array([0, 0, 30.0]), 0, 0, 0), near_m=1, far_m=100)
        position, _ = pybullet.getBasePositionAndOrientation(world._handles[car.index], world._client)
        np.testing.assert_allclose(position, [6.0, -3.0, 1.0])
        rows, columns = np.nonzero(index == car.index)
        # Ahead is up; left is left: 6 m ahead and 3 m to the right, 29 m below. Corners of pixels are sampled.
        assert rows.mean() == pytest.approx(60 - 6 * camera.focal_px / 29, abs=1.3)
        assert columns.mean() == pytest.approx(80 + 3 * camera.focal_px / 29, abs=1.3)
        assert (rgb[rows, columns] == (250, 0, 0)).all()
        assert (rgb[index == 0] == (10, 200, 30)).all()


def test_fixed_bodies_cannot_be_moved():
    with World() as world:
        house = world.add(square(1, 0), np.eye(4), name="house", category="building")
        with pytest.raises(ValueError, match="body: expected a movable one, got 'house'"):
            world.move(house, np.eye(4))
        with pytest.raises(ValueError, match="body: expected a movable one, got 'house'"):
            world.move_all([house], np.eye(4)[None])


def test_bodies_moved_at_once_are_where_they_are_moved_one_by_one():
    with World() as world:
        cars = [world.add(square(4, 0), np.eye(4), name=f"{k}", category="vehicle", movable=True) for k in range(3)]
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, :3, 3] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
        world.move_all([cars[2], cars[0]], poses)
        world.hand_over()
        for car, pose in ((cars[2], poses[0]), (cars[0], poses[1]), (cars[1], np.eye(4))):
            np.testing.assert_array_equal(world.poses[car.index], pose)
            position, _ = pybullet.getBasePositionAndOrientation(world._handles[car.index], world._client)
            np.testing.assert_allclose(position, pose[:3, 3])


def test_worlds_that_come_and_go_leave_no_lists_behind():
    count = 3000
    strip = TexturedMesh(
        np.random.default_rng(4).normal(size=(count, 3)).astype(np.float32),
        np.tile(np.array([0, 0, 1], dtype=np.float32), (count, 1)),
        np.zeros((count, 2), dtype=np.float32),
        np.arange(count, dtype=np.int32).reshape(-1, 3),
        Texture(np.zeros((4, 4, 3), dtype=np.uint8)),
    )

    def live() -> int:
        with World() as world:
            world.add(strip, np.eye(4), name="strip", category="kerb")
        gc.collect()
        return sys.getallocatedblocks()

    live()
    before = live()
    for _ in range(4):
        after = live()
    assert after - before < 0.1 * count


def test_shapes_of_several_sizes_keep_their_own_points():
    with World() as world:
        small = world.add(square(2, (9, 9, 9)), np.eye(4), name="small", category="kerb")
        wide = np.eye(4)
        wide[:3, 3] = [0, 0, -1]
        big = world.add(square(40, (90, 9, 9)), wide, name="big", category="ground")
        again = np.eye(4)
        again[:3, 3] = [8, 0, 0]
        last = world.add(square(2, (9, 90, 9)), again, name="last", category="kerb")
        camera = PinholeCamera.from_field_of_view(160, 120, 1.0)
        _, _, index = world.camera_image(camera, look_down_pose(np.array([0, 0, 30.0]), 0, 0, 0), near_m=1, far_m=100)
        pixels_per_m = camera.focal_px / 30
        for body in (small, last):
            assert (index == body.index).sum() == pytest.approx((2 * pixels_per_m) ** 2, rel=0.25)
        assert (index == big.index).sum() > 0.9 * index.size


def test_worlds_do_not_leak_connections():
    for _ in range(40):
        with World() as world:
            world.add(square(1, 0), np.eye(4), name="x", category="ground")
