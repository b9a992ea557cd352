"""The rasteriser against ray casting and plain arithmetic; before a camera at rest, against pictures drawn whole."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.mesh import Texture
from sim.optics import PinholeCamera, look_down_pose, project, rays
from sim.pose import pose_on_ground
from sim.render.raster import Raster
from sim.world import World
from tests.sim.demo_scene import box, cone, ground, palette, pose
from tests.sim.ray_casting import RayCaster, away_from_edges

CAMERA = PinholeCamera.from_field_of_view(160, 120, np.radians(55))
GREY = Texture(np.full((4, 4, 3), 128, np.uint8))
VIEWS = {
    "down": (np.array([5.0, 8.0, 60.0]), 0.3, 0.0, 0.0),
    "tilted": (np.array([-30.0, 10.0, 45.0]), 2.0, 0.5, -0.3),
    "horizon": (np.array([0.0, -20.0, 20.0]), 4.0, 1.3, 0.1),
    "low": (np.array([0.0, 0.0, 2.0]), 1.0, 1.55, 0.0),
}


@pytest.mark.parametrize("view", VIEWS)
def test_ids_and_depth_are_those_of_ray_casting(town, view):
    T_world_camera = look_down_pose(*VIEWS[view])
    gbuffer = Raster(town).gbuffer(CAMERA, T_world_camera)
    rng = np.random.default_rng(0)
    row, column = rng.integers(0, CAMERA.height_px, 500), rng.integers(0, CAMERA.width_px, 500)
    directions = rays(CAMERA, T_world_camera, np.column_stack([column, row]) + 0.5)
    depth_m, body = RayCaster(town).nearest(np.tile(T_world_camera[:3, 3], (500, 1)), directions)
    # Near edges the last bit of either arithmetic decides; elsewhere nothing may differ.
    clear = away_from_edges(gbuffer.instance_id)[row, column]
    assert clear.mean() > 0.5
    np.testing.assert_array_equal(gbuffer.instance_id[row, column][clear], body[clear])
    np.testing.assert_allclose(gbuffer.depth_m[row, column][clear], depth_m[clear], rtol=3e-5)
    assert (gbuffer.instance_id[row, column] == body).mean() > 0.99


@pytest.mark.parametrize("view", VIEWS)
def test_sky_has_no_depth_colour_or_normal_and_surfaces_have_unit_normals_towards_the_camera(town, view):
    T_world_camera = look_down_pose(*VIEWS[view])
    gbuffer = Raster(town).gbuffer(CAMERA, T_world_camera)
    sky = gbuffer.instance_id == SKY
    assert np.isinf(gbuffer.depth_m[sky]).all()
    assert (gbuffer.base_colour_rgb[sky] == 0).all()
    assert (gbuffer.normal_world[sky] == 0).all()
    np.testing.assert_allclose(np.linalg.norm(gbuffer.normal_world[~sky], axis=-1), 1.0, atol=1e-5)
    row, column = np.nonzero(~sky & (gbuffer.instance_id < 31))  # ground and boxes: flat faces
    directions = rays(CAMERA, T_world_camera, np.column_stack([column, row]) + 0.5)
    facing = np.einsum("ij,ij->i", directions, gbuffer.normal_world[row, column])
    assert (facing < 1e-4).all()


@given(
    st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(0.5, 80)),
    st.floats(-4, 4),
    st.floats(-1.5, 1.5),
    st.floats(-1.5, 1.5),
)
@example((0.0, 0.0, 1.0), 0.0, 0.0, 0.0)  # a common edge runs exactly through pixel centres
@settings(max_examples=120, deadline=None)
def test_a_tiled_plane_has_no_cracks(tiled_plane, position_m, yaw, pitch, roll):
    camera = PinholeCamera.from_field_of_view(64, 48, 1.2)
    T_world_camera = look_down_pose(np.array(position_m), yaw, pitch, roll)
    gbuffer = tiled_plane.gbuffer(camera, T_world_camera)
    pixels = np.stack(np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5), axis=-1)
    directions = rays(camera, T_world_camera, pixels)
    with np.errstate(divide="ignore"):
        depth_m = -position_m[2] / directions[..., 2]
    hit = position_m + directions * depth_m[..., None]
    on_plane = (depth_m > 0.21) & (np.abs(hit[..., :2]).max(-1) < 999.0)
    off_plane = (depth_m < 0.0) | (np.abs(hit[..., :2]).max(-1) > 1001.0) | (depth_m < 0.19)
    assert (gbuffer.instance_id[on_plane] == 0).all()
    assert (gbuffer.instance_id[off_plane] == SKY).all()
    np.testing.assert_allclose(gbuffer.depth_m[on_plane], depth_m[on_plane], rtol=1e-3)


@pytest.fixture(scope="module")
def tiled_plane():
    world = World()
    world.add(ground(2000.0, GREY, cells=40), np.eye(4), name="plane", category="ground")
    return Raster(world)


def test_grid_lines_through_pixel_centres_leave_no_cracks(tiled_plane):
    # 50 m cells from 100 m with f = 100: every grid line falls exactly on pixel centres when shifted by half.
    camera = PinholeCamera(101, 101, 100.0)
    gbuffer = tiled_plane.gbuffer(camera, look_down_pose(np.array([0, 0, 100.0]), 0, 0, 0))
    assert (gbuffer.instance_id == 0).all()


def test_back_faces_are_not_drawn():
    world = World()
    world.add(ground(50.0, GREY), np.eye(4), name="plane", category="ground")
    from_below = look_down_pose(np.array([0, 0, -10.0]), 0, np.pi, 0)
    assert (Raster(world).gbuffer(CAMERA, from_below).instance_id == SKY).all()


def test_projected_corners_are_where_the_drawn_box_is():
    T_world_camera = look_down_pose(*VIEWS["tilted"])
    world = World()
    body = world.add(box((6, 3, 2), GREY), pose(-27, 36, 0.5), name="box", category="building")
    gbuffer = Raster(world).gbuffer(CAMERA, T_world_camera)
    corners_m = body.mesh.vertices_m @ world.poses[0][:3, :3].T + world.poses[0][:3, 3]
    pixels, _ = project(CAMERA, T_world_camera, corners_m)
    row, column = np.nonzero(gbuffer.instance_id == 0)
    # A pixel is drawn if its centre is inside.
    np.testing.assert_allclose([column.min(), row.min()], pixels.min(axis=0) - 0.5, atol=1.0)
    np.testing.assert_allclose([column.max(), row.max()], pixels.max(axis=0) - 0.5, atol=1.0)


def test_palette_colours_are_exact_and_smooth_normals_interpolate():
    rng = np.random.default_rng(2)
    texture = palette(rng)
    world = World()
    world.add(box((10, 10, 1), texture), np.eye(4), name="slab", category="building")
    gbuffer = Raster(world).gbuffer(CAMERA, look_down_pose(np.array([0, 0, 5.0]), 0, 0, 0))
    assert (gbuffer.base_colour_rgb == texture.rgb[4, 4 * 8 + 4]).all()
    np.testing.assert_allclose(gbuffer.normal_world - [0, 0, 1], 0, atol=1e-6)
    world = World()
    world.add(cone(3.0, 2.0, GREY, sides=24), np.eye(4), name="cone", category="tree")
    gbuffer = Raster(world).gbuffer(CAMERA, look_down_pose(np.array([0, 0, 9.0]), 0, 0, 0))
    row, column = np.nonzero(gbuffer.instance_id == 0)
    direction = rays(CAMERA, look_down_pose(np.zeros(3), 0, 0, 0), np.column_stack([column, row]) + 0.5)
    aside = direction[:, :2] / np.linalg.norm(direction[:, :2], axis=1, keepdims=True)
    outward = np.einsum("ij,ij->i", gbuffer.normal_world[row, column, :2], aside)
    assert np.median(outward) > 0.8 * np.sin(np.arctan2(2.0, 3.0))
    assert (gbuffer.normal_world[row, column, 2] > 0.3).all()


def _bilinear(texture: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    height, width = texture.shape[:2]
    x, y = np.clip(u * width - 0.5, 0, width - 1), np.clip(v * height - 0.5, 0, height - 1)
    j, i = np.minimum(x.astype(int), width - 2), np.minimum(y.astype(int), height - 2)
    fx, fy = (x - j)[..., None], (y - i)[..., None]
    top = texture[i, j] * (1 - fx) + texture[i, j + 1] * fx
    bottom = texture[i + 1, j] * (1 - fx) + texture[i + 1, j + 1] * fx
    return top * (1 - fy) + bottom * fy


@pytest.mark.parametrize("size", [(64, 64), (37, 50)])
def test_smooth_textures_are_interpolated(size):
    picture = np.random.default_rng(3).integers(0, 256, (*size, 3), dtype=np.uint8)
    T_world_camera = look_down_pose(np.array([1.0, -2.0, 12.0]), 0.7, 0.2, 0.1)
    world = World()
    world.add(ground(40.0, Texture(picture, smooth=True)), np.eye(4), name="plane", category="ground")
    gbuffer = Raster(world).gbuffer(CAMERA, T_world_camera)
    row, column = np.mgrid[: CAMERA.height_px, : CAMERA.width_px]
    directions = rays(CAMERA, T_world_camera, np.stack([column, row], axis=-1) + 0.5)
    points_m = T_world_camera[:3, 3] + directions * gbuffer.depth_m[..., None].astype(float)
    expected = _bilinear(picture.astype(float), points_m[..., 0] / 40 + 0.5, 0.5 - points_m[..., 1] / 40)
    # Weights are rounded down to 1/256: up to two steps of 255 / 256 codes in each direction, and rounding.
    difference = gbuffer.base_colour_rgb - expected
    assert np.abs(difference).max() < 3.0
    assert np.abs(difference.mean()) < 0.3


def test_far_away_a_fine_pattern_is_its_mean():
    checks = (np.indices((256, 256)).sum(0) % 2 * 200 + 20).astype(np.uint8)
    texture = Texture(np.repeat(checks[..., None], 3, axis=2), smooth=True)
    world = World()
    world.add(ground(100.0, texture), np.eye(4), name="plane", category="ground")
    gbuffer = Raster(world).gbuffer(CAMERA, look_down_pose(np.array([0, 0, 90.0]), 0.3, 0, 0))
    inside = away_from_edges(gbuffer.instance_id, 4) & (gbuffer.instance_id == 0)
    assert np.abs(gbuffer.base_colour_rgb[inside].astype(int) - 120).max() <= 2


def test_pictures_are_fresh_repeatable_and_follow_the_world(town):
    raster = Raster(town)
    T_world_camera = look_down_pose(*VIEWS["down"])
    first = raster.gbuffer(CAMERA, T_world_camera)
    copies = [array.copy() for array in (first.base_colour_rgb, first.depth_m, first.instance_id)]
    raster.gbuffer(CAMERA, look_down_pose(*VIEWS["tilted"]))
    again = Raster(town).gbuffer(CAMERA, T_world_camera)
    for array, copy, repeat in zip(
        (first.base_colour_rgb, first.depth_m, first.instance_id),
        copies,
        (again.base_colour_rgb, again.depth_m, again.instance_id),
        strict=True,
    ):
        np.testing.assert_array_equal(array, copy)
        np.testing.assert_array_equal(array, repeat)


def test_bodies_may_be_added_and_moved_between_pictures():
    straight_down = look_down_pose(np.array([0, 0, 30.0]), 0, 0, 0)
    world = World()
    raster = Raster(world)
    assert (raster.gbuffer(CAMERA, straight_down).instance_id == SKY).all()
    body = world.add(box((2, 2, 2), GREY), pose(0, 0), name="box", category="vehicle", movable=True)
    assert raster.gbuffer(CAMERA, straight_down).instance_id[60, 80] == 0
    world.move(body, pose(8, 0))
    moved = raster.gbuffer(CAMERA, straight_down).instance_id
    assert moved[60, 80] == SKY
    assert (moved == 0).any()


SMALL_CAMERA = PinholeCamera(120, 90, 110.0)
RESTING_VIEWS = [look_down_pose(np.array([x, -2.0, 14.0]), 0.2, 0.3, 0.0) for x in (0.0, 0.4)]
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
    kept, whole = raster.gbuffer(SMALL_CAMERA, T_world_camera), Raster(world).gbuffer(SMALL_CAMERA, T_world_camera)
    for name in kept._fields:
        assert getattr(kept, name).tobytes() == getattr(whole, name).tobytes(), name
    assert raster.normals(SMALL_CAMERA, T_world_camera).tobytes() == whole.normal_world.tobytes()


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
        _assert_drawn_whole(raster, world, RESTING_VIEWS[view])


@pytest.mark.parametrize("mover", MOVERS[:2])
def test_a_body_as_near_as_a_kept_one_is_drawn_by_its_order(mover):
    world = _world()
    raster = Raster(world)
    for k in range(8):
        place = SEAT_M if k > 3 else (5.0 + k, 5.0)
        world.move(world.bodies[mover], pose_on_ground(*place, 0.0))
        _assert_drawn_whole(raster, world, RESTING_VIEWS[0])
    seen = raster.gbuffer(SMALL_CAMERA, RESTING_VIEWS[0]).instance_id
    assert (seen == min(mover, 2)).sum() > 20
    assert not (seen == max(mover, 2)).any()


def test_what_is_at_rest_is_drawn_once():
    world = _world()
    raster = Raster(world)
    for k in range(20):
        world.move(world.bodies[4], pose_on_ground(0.1 * k, 0.0, 0.0))
        raster.gbuffer(SMALL_CAMERA, RESTING_VIEWS[0])
    # The first picture of the view, and the layer of the second.
    assert raster._canvas.pictures_of_all == 2
    for k in range(20):
        world.move(world.bodies[1], pose_on_ground(0.1 * k, 2.0, 0.0))
        raster.gbuffer(SMALL_CAMERA, RESTING_VIEWS[0])
    # A body of the layer moved; later one came to rest.
    assert raster._canvas.pictures_of_all == 4
    raster.gbuffer(SMALL_CAMERA, RESTING_VIEWS[1])
    raster.normals(SMALL_CAMERA, RESTING_VIEWS[1])
    assert raster._canvas.pictures_of_all == 5


def test_bodies_that_are_added_are_drawn(world):
    growing = _world()
    raster = Raster(growing)
    for _ in range(3):
        _assert_drawn_whole(raster, growing, RESTING_VIEWS[0])
    growing.add(box((3.0, 3.0, 3.0), _texture(1)), np.eye(4), name="new", category="thing")
    for _ in range(3):
        _assert_drawn_whole(raster, growing, RESTING_VIEWS[0])
    assert (raster.gbuffer(SMALL_CAMERA, RESTING_VIEWS[0]).instance_id == 7).any()


def test_pictures_of_other_sizes_are_drawn_whole(world):
    raster = Raster(world)
    for camera in (SMALL_CAMERA, SMALL_CAMERA, PinholeCamera(60, 45, 55.0), SMALL_CAMERA):
        kept, whole = raster.gbuffer(camera, RESTING_VIEWS[0]), Raster(world).gbuffer(camera, RESTING_VIEWS[0])
        assert kept.depth_m.tobytes() == whole.depth_m.tobytes()
