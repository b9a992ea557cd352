"""Objects are taken out of the world and come back, and parts have the id of their object."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios import catalog
from scenarios.objects import AWAY, JointedObjects, Objects, add_parts
from sim.meshes.facets import Facets
from sim.world import World


def two_boxes_of_two_parts() -> tuple[World, JointedObjects]:
    cube = Facets()
    cube.box((-0.5, -0.5, 0.0), (0.5, 0.5, 1.0), (0.5, 0.5))
    world, mesh = World(), cube.mesh([(9, 9, 9)])
    parts = [add_parts(world, name, "box", {"low": mesh, "high": mesh}) for name in ("target", "other")]
    return world, JointedObjects(world, ["target", "other"], ["box"] * 2, parts, np.ones((2, 3)))


def test_what_is_taken_out_is_absent_until_it_is_moved_again() -> None:
    world, jointed = two_boxes_of_two_parts()
    rigid = Objects(world, world.bodies[:1])
    jointed.take_out([1])
    assert jointed.present.tolist() == [True, False]
    assert np.isnan(jointed.bounds_m()[1]).all()
    np.testing.assert_array_equal(world.poses[2:4], [AWAY, AWAY])
    jointed.move_parts(1, np.tile(np.eye(4), (2, 1, 1)))
    rigid.take_out()
    assert jointed.present.all()
    assert not rigid.present.any()
    rigid.move(np.eye(4)[None], np.zeros(1))
    assert rigid.present.all()
    np.testing.assert_array_equal(world.poses, np.tile(np.eye(4), (4, 1, 1)))


def test_parts_have_the_id_of_their_object_and_bodies_that_are_added_later_their_own() -> None:
    world, jointed = two_boxes_of_two_parts()
    world.add(world.bodies[0].mesh, np.eye(4), name="late", category="wall")
    seen = np.array([[-1, 0, 1, 2, 3, 4]], np.int32)
    jointed.merge(seen)
    assert seen.tolist() == [[-1, 0, 0, 2, 2, 4]]


def test_an_env_id_that_gymnasium_cannot_read_is_refused() -> None:
    with pytest.raises(ValueError, match=r"env_id: expected a name with its version, such as .*, got 'my env-v1'"):
        catalog.register(catalog.Entry("own-v1", "own:OWN", env_id="my env-v1", tracker="hold"))
    assert "own-v1" not in catalog.names()
