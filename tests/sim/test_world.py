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


def test_what_is_removed_is_gone_and_indices_go_on_from_what_is_left():
    world = World()
    for name in "abc":
        world.add(square(1, 0), np.eye(4), name=name, category="kerb")
    world.remove_after(1)
    assert [(body.index, body.name) for body in world.bodies] == [(0, "a")]
    assert world.add(square(1, 0), np.eye(4), name="d", category="kerb").index == 1
    assert world.poses.shape == (2, 4, 4)
