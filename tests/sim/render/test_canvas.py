"""Pictures of a camera at rest, of which only what moved is drawn again, against pictures drawn whole."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sim.mesh import Texture
from sim.optics import look_down_pose
from sim.pose import pose_on_ground
from sim.render.raster import Raster
from sim.world import World
from tests.sim.demo_scene import box, cone, ground
from trackers.types import CameraModel

CAMERA = CameraModel(120, 90, 110.0)
VIEWS = [look_down_pose(np.array([x, -2.0, 14.0]), 0.2, 0.3, 0.0) for x in (0.0, 0.4)]
MOVERS = (1, 3, 4, 6)
"""Bodies that may move, between others that do not: the order of bodies decides between equally near surfaces."""
SEAT_M = (1.0, 1.0)
"""Where a box of each kind stands: a mover that comes there covers the same pixels at the same depth."""


def _texture(seed: int) -> Texture:
    rgb = np.random.default_rng(seed).integers(0, 256, (16, 48, 3)).astype(np.uint8)
    return Texture(rgb, smooth=seed % 2 == 0)


def _world() -> World:
    world = World()
    meshes = [
        ground(40.0, _texture(0), cells=3),
        box((2.0, 2.0, 1.0), _texture(1)),
        box((2.0, 2.0, 1.0), _texture(2)),
        box((2.0, 2.0, 1.0), _texture(3)),
        cone(1.0, 2.0, _texture(4)),
        box((2.0, 2.0, 1.0), _texture(5)),
        ground(12.0, _texture(6)),
    ]
    for k, mesh in enumerate(meshes):
        place = SEAT_M if k in (2, 5) else (0.0, 0.0) if k == 0 else (3.0 - k, 0.6 * k - 3.0)
        world.add(mesh, pose_on_ground(*place, 0.0), name=f"{k}", category="thing", movable=k in MOVERS)
    return world


@pytest.fixture(scope="module")
def world() -> World:
    """Return a world of two boxes in one place among bodies that move."""
    return _world()


def _assert_drawn_whole(raster: Raster, world: World, T_world_camera: NDArray[np.float64]) -> None:
    kept, whole = raster.gbuffer(CAMERA, T_world_camera), Raster(world).gbuffer(CAMERA, T_world_camera)
    for name in kept._fields:
        assert getattr(kept, name).tobytes() == getattr(whole, name).tobytes(), name
    assert raster.normals(CAMERA, T_world_camera).tobytes() == whole.normal_world.tobytes()


MOVES = st.lists(
    st.tuples(
        st.sampled_from(MOVERS),
        st.one_of(st.just(SEAT_M), st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0))),
        st.sampled_from([0.0, 0.0, 0.7]),
    ),
    max_size=2,
)


@given(st.lists(st.tuples(MOVES, st.sampled_from([0, 0, 0, 0, 0, 1])), min_size=6, max_size=14))
@settings(max_examples=15, deadline=None)
def test_pictures_in_sequence_equal_pictures_drawn_whole(world, steps):
    raster = Raster(world)
    for moves, view in steps:
        for index, (x, y), turn in moves:
            world.move(world.bodies[index], pose_on_ground(x, y, turn))
        _assert_drawn_whole(raster, world, VIEWS[view])


@pytest.mark.parametrize("mover", MOVERS[:2])
def test_a_body_as_near_as_a_kept_one_is_drawn_by_its_order(mover):
    world = _world()
    raster = Raster(world)
    for k in range(8):
        place = SEAT_M if k > 3 else (5.0 + k, 5.0)
        world.move(world.bodies[mover], pose_on_ground(*place, 0.0))
        _assert_drawn_whole(raster, world, VIEWS[0])
    seen = raster.gbuffer(CAMERA, VIEWS[0]).instance_id
    assert (seen == min(mover, 2)).sum() > 20
    assert not (seen == max(mover, 2)).any()


def test_what_is_at_rest_is_drawn_once():
    world = _world()
    raster = Raster(world)
    for k in range(20):
        world.move(world.bodies[4], pose_on_ground(0.1 * k, 0.0, 0.0))
        raster.gbuffer(CAMERA, VIEWS[0])
    # The first picture of the view, and the layer of the second.
    assert raster._canvas.pictures_of_all == 2
    for k in range(20):
        world.move(world.bodies[1], pose_on_ground(0.1 * k, 2.0, 0.0))
        raster.gbuffer(CAMERA, VIEWS[0])
    # A body of the layer moved; later one came to rest.
    assert raster._canvas.pictures_of_all == 4
    raster.gbuffer(CAMERA, VIEWS[1])
    raster.normals(CAMERA, VIEWS[1])
    assert raster._canvas.pictures_of_all == 5


def test_bodies_that_are_added_are_drawn(world):
    growing = _world()
    raster = Raster(growing)
    for _ in range(3):
        _assert_drawn_whole(raster, growing, VIEWS[0])
    growing.add(box((3.0, 3.0, 3.0), _texture(1)), np.eye(4), name="new", category="thing")
    for _ in range(3):
        _assert_drawn_whole(raster, growing, VIEWS[0])
    assert (raster.gbuffer(CAMERA, VIEWS[0]).instance_id == 7).any()


def test_pictures_of_other_sizes_are_drawn_whole(world):
    raster = Raster(world)
    for camera in (CAMERA, CAMERA, CameraModel(60, 45, 55.0), CAMERA):
        kept, whole = raster.gbuffer(camera, VIEWS[0]), Raster(world).gbuffer(camera, VIEWS[0])
        assert kept.depth_m.tobytes() == whole.depth_m.tobytes()
