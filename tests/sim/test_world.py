"""A world is a list of bodies and poses, with no engine behind it."""

from __future__ import annotations

import numpy as np
import pytest

from sim.world import World
from tests.sim.squares import square


def test_fixed_bodies_cannot_be_moved():
    world = World()
    house = world.add(square(1, 0), np.eye(4), name="house", category="building")
    with pytest.raises(ValueError, match="body: expected a movable one, got 'house'"):
        world.move(house, np.eye(4))
    with pytest.raises(ValueError, match="body: expected a movable one, got 'house'"):
        world.move_all([house], np.eye(4)[None])


def test_bodies_moved_at_once_are_where_they_are_moved_one_by_one():
    world = World()
    cars = [world.add(square(4, 0), np.eye(4), name=f"{k}", category="vehicle", movable=True) for k in range(3)]
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, :3, 3] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    world.move_all([cars[2], cars[0]], poses)
    np.testing.assert_array_equal(world.poses, [poses[1], np.eye(4), poses[0]])
    world.move(cars[1], poses[0])
    np.testing.assert_array_equal(world.poses, [poses[1], poses[0], poses[0]])


def test_a_copy_has_the_bodies_and_poses_of_its_own():
    world = World()
    kerb = world.add(square(1, 0), np.eye(4), name="a", category="kerb")
    car = world.add(square(1, 0), np.eye(4), name="b", category="vehicle", movable=True)
    copy = world.copy()
    assert copy.original is world
    assert copy.bodies == [kerb, car]
    copy.move(car, 2 * np.eye(4))
    assert copy.add(square(1, 0), np.eye(4), name="d", category="kerb").index == 2
    assert [body.name for body in world.bodies] == ["a", "b"]
    np.testing.assert_array_equal(world.poses, [np.eye(4)] * 2)
    np.testing.assert_array_equal(copy.poses, [np.eye(4), 2 * np.eye(4), np.eye(4)])
