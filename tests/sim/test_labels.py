"""Labels against drawn ids, projected points, and the pictures of two instants."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sim.labels import (
    amodal_box,
    amodal_boxes,
    backward_flow,
    bright_fractions,
    ground_homography,
    outline,
    pixels_from_ground,
    seen_ids,
    visible_fraction,
)
from sim.mesh import Texture, TexturedMesh
from sim.meshes.vehicle import VEHICLES, vehicle
from sim.optics import intersect_plane, look_down_pose, project
from sim.render.raster import Raster
from sim.world import World
from trackers.types import CameraModel

CAMERA = CameraModel.from_field_of_view(320, 240, np.deg2rad(50.0))
GREY = Texture(np.full((2, 2, 3), 128, dtype=np.uint8))


def _mesh(shape: trimesh.Trimesh) -> TexturedMesh:
    corners = shape.triangles.reshape(-1, 3).astype(np.float32)
    normals = np.repeat(shape.face_normals, 3, axis=0).astype(np.float32)
    faces = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    return TexturedMesh(corners, normals, np.full((len(corners), 2), 0.5, np.float32), faces, GREY)


CAR = _mesh(trimesh.creation.box((4.5, 1.8, 1.5), trimesh.transformations.translation_matrix([0, 0, 0.75])))
GROUND = _mesh(trimesh.creation.box((200, 200, 0.2), trimesh.transformations.translation_matrix([0, 0, -0.1])))


def _pose(x: float, y: float, yaw: float = 0.0) -> np.ndarray:
    T = trimesh.transformations.rotation_matrix(yaw, [0, 0, 1])
    T[:2, 3] = x, y
    return T


def _drawn(place, camera_pose, extra=()):
    world = World()
    world.add(GROUND, np.eye(4), name="ground", category="ground")
    car = world.add(CAR, place, name="car", category="vehicle", movable=True)
    for k, pose in enumerate(extra):
        world.add(CAR, pose, name=f"other-{k}", category="vehicle")
    return world, car, Raster(world).gbuffer(CAMERA, camera_pose)


@pytest.mark.parametrize("yaw", [0.0, 0.7, 2.0])
def test_box_is_that_of_the_drawn_ids(yaw):
    pose = look_down_pose(np.array([0, 0, 40.0]), 0.3, 0.2, -0.1)
    _, car, gbuffer = _drawn(_pose(5, 3, yaw), pose)
    rows, columns = np.nonzero(gbuffer.instance_id == car.index)
    box = amodal_box(CAMERA, pose, CAR, _pose(5, 3, yaw))
    drawn = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
    np.testing.assert_allclose(box, drawn, atol=1.0)


def test_boxes_of_many_are_those_of_each_to_the_last_bit():
    meshes = [vehicle(model, (90, 20, 20)) for model in VEHICLES]
    rng = np.random.default_rng(7)
    for _ in range(40):
        places = np.array([_pose(*rng.uniform(-60, 60, 2), rng.uniform(-np.pi, np.pi)) for _ in meshes])
        pose = look_down_pose(np.array([0, 0, rng.uniform(5, 90)]), *rng.uniform(-1.5, 1.5, 3))
        each = [amodal_box(CAMERA, pose, mesh, place) for mesh, place in zip(meshes, places, strict=True)]
        np.testing.assert_array_equal(amodal_boxes(CAMERA, pose, outline(meshes), places), each)


def test_box_goes_on_outside_and_is_nan_behind():
    pose = look_down_pose(np.array([0, 0, 40.0]), 0.0, 0.0, 0.0)
    assert amodal_box(CAMERA, pose, CAR, _pose(60, 0))[3] < 0
    level = look_down_pose(np.array([0, 0, 40.0]), 0.0, np.pi / 2, 0.0)
    assert np.isnan(amodal_box(CAMERA, level, CAR, _pose(-60, 0))).all()


@pytest.mark.parametrize("seed", range(3))
def test_seen_ids_are_those_of_the_map(seed):
    rng = np.random.default_rng(seed)
    ids = rng.choice([-1, 0, 3, 4, 11], (20, 30)).astype(np.int32)
    ids[rng.random(ids.shape) < 0.5] = 7
    assert np.flatnonzero(seen_ids(ids, 12)).tolist() == np.unique(ids[ids >= 0]).tolist()
    assert not seen_ids(np.full((4, 5), -1, np.int32), 12).any()


def test_bright_shares_are_counted_pixel_by_pixel():
    rng = np.random.default_rng(0)
    image_rgb = rng.integers(150, 256, (20, 30, 3), dtype=np.uint8)
    ids = rng.choice([-1, 2, 5, 6, 40], (20, 30)).astype(np.int32)
    asked = np.array([6, 2, 9])
    is_bright = (image_rgb >= 200).all(axis=2)
    expected = [is_bright[ids == 6].mean(), is_bright[ids == 2].mean(), 0.0]
    np.testing.assert_allclose(bright_fractions(image_rgb, ids, asked, 200), expected)


def test_fraction_whole_cut_hidden_and_outside():
    pose = look_down_pose(np.array([0, 0, 40.0]), 0.0, 0.0, 0.0)

    def fraction(place, extra=()):
        _, car, gbuffer = _drawn(place, pose, extra)
        return visible_fraction(gbuffer, CAMERA, pose, CAR, place, car.index, amodal_box(CAMERA, pose, CAR, place))

    assert fraction(_pose(2, 1, 0.4)) == 1.0
    assert fraction(_pose(60, 0)) == 0.0
    # The border cuts the roof in half; of the side that looks this way all is inside.
    half_ahead_m = 0.5 * CAMERA.height_px / CAMERA.focal_px * (40.0 - 1.5)
    roof = 1.8 / 38.5
    side = (half_ahead_m - 0.9) * (1 / 38.5 - 1 / 40.0)
    expected = (0.5 * roof + side) / (roof + side)
    assert fraction(_pose(half_ahead_m, 0, np.pi / 2)) == pytest.approx(expected, abs=0.03)
    over = _pose(2.25, 0)
    over[2, 3] = 5.0
    hidden = fraction(_pose(0, 0), [over])
    # The edge of the cover is right below the camera, over the middle of the car.
    assert hidden == pytest.approx(0.5, abs=0.02)


def test_fraction_is_that_of_drawing_it_alone_on_a_large_picture():
    pose = look_down_pose(np.array([0, 0, 40.0]), 0.2, 0.1, 0.1)
    place = _pose(12.5, 10, 0.5)
    _, car, gbuffer = _drawn(place, pose, [_pose(10, 11.5, 1.4)])
    large = CameraModel(3 * 320, 3 * 240, CAMERA.focal_px)
    world_alone, car_alone, _ = _drawn(place, pose)
    alone = Raster(world_alone).gbuffer(large, pose)
    expected = (gbuffer.instance_id == car.index).sum() / (alone.instance_id == car_alone.index).sum()
    assert 0.05 < expected < 0.98
    box = amodal_box(CAMERA, pose, CAR, place)
    measured = visible_fraction(gbuffer, CAMERA, pose, CAR, place, car.index, box)
    assert measured == pytest.approx(expected, abs=0.01)


def _homography(before, after):
    return ground_homography(pixels_from_ground(CAMERA, before), pixels_from_ground(CAMERA, after))


def test_homography_takes_ground_pixels_along():
    before = look_down_pose(np.array([0, 0, 40.0]), 0.0, 0.1, 0.0)
    after = look_down_pose(np.array([3, -2, 42.0]), 0.2, -0.1, 0.15)
    pixels = np.random.default_rng(0).uniform(0, 240, (30, 2))
    ground = np.column_stack([intersect_plane(CAMERA, before, pixels, 0.0), np.zeros(30)])
    expected, _ = project(CAMERA, after, ground)
    moved = np.column_stack([pixels, np.ones(30)]) @ _homography(before, after).T
    np.testing.assert_allclose(moved[:, :2] / moved[:, 2:], expected, atol=1e-6)


def test_flow_of_everything_at_rest_is_zero():
    pose = look_down_pose(np.array([0, 0, 40.0]), 0.1, 0.1, 0.0)
    world, _, gbuffer = _drawn(_pose(3, 2), pose)
    flow = backward_flow(gbuffer, CAMERA, pose, pose, world.poses, world.poses)
    # float32 depth of 40 m is good to 4 µm, a pixel to 0.1 m.
    assert np.abs(flow).max() < 1e-3


def test_flow_leads_to_the_same_surface_in_the_frame_before():
    before_pose = look_down_pose(np.array([0, 0, 40.0]), 0.1, 0.1, 0.0)
    after_pose = look_down_pose(np.array([1.0, 0.5, 41.0]), 0.15, 0.05, 0.03)
    world, car, before = _drawn(_pose(3, 2, 0.3), before_pose)
    poses_before = world.poses.copy()
    world.move(car, _pose(4.2, 2.4, 0.45))
    after = Raster(world).gbuffer(CAMERA, after_pose)
    flow = backward_flow(after, CAMERA, after_pose, before_pose, world.poses, poses_before)
    rows, columns = np.nonzero(after.instance_id == car.index)
    u = columns + 0.5 + flow[rows, columns, 0]
    v = rows + 0.5 + flow[rows, columns, 1]
    inside = (u > 0) & (u < 319) & (v > 0) & (v < 239)
    hit = before.instance_id[v[inside].astype(int), u[inside].astype(int)] == car.index
    assert hit.mean() > 0.9
    # A point fixed to the car, projected by hand at both instants.
    roof = np.array([1.0, 0.3, 1.5, 1.0])
    now, _ = project(CAMERA, after_pose, (world.poses[car.index] @ roof)[:3])
    then, _ = project(CAMERA, before_pose, (poses_before[car.index] @ roof)[:3])
    np.testing.assert_allclose(flow[int(now[1]), int(now[0])], then - now, atol=0.15)


def test_ground_flow_is_the_homographys():
    before_pose = look_down_pose(np.array([0, 0, 40.0]), 0.1, 0.1, 0.0)
    after_pose = look_down_pose(np.array([1.0, 0.5, 41.0]), 0.15, 0.05, 0.03)
    world, _, gbuffer = _drawn(_pose(500, 0), after_pose)
    flow = backward_flow(gbuffer, CAMERA, after_pose, before_pose, world.poses, world.poses)
    H = _homography(after_pose, before_pose)
    columns, rows = np.meshgrid(np.arange(320) + 0.5, np.arange(240) + 0.5)
    moved = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ H.T
    expected = moved[..., :2] / moved[..., 2:] - np.stack([columns, rows], axis=-1)
    np.testing.assert_allclose(flow, expected, atol=2e-3)
