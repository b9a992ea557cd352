"""Labels of bodies of several parts: of one part those of ``sim.labels``, of more those of brute force."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim.jointed_labels import SeenBody, enclosing_bounds, joined, merge_parts, seen_bodies, seen_body
from sim.labels import amodal_box, visible_fraction
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.optics import look_down_pose, project
from trackers.types import CameraModel

CAMERA = CameraModel(64, 48, 60.0)
POSE = look_down_pose(np.array([0.0, 0.0, 1.0]), 0.0, 0.5 * np.pi, 0.0)
OWN, NEAR, FAR = 5, 7, 9


def block(size_m: tuple[float, float, float]) -> TexturedMesh:
    facets = Facets()
    x, y, z = (0.5 * side for side in size_m)
    facets.box((-x, -y, -z), (x, y, z), (0.5, 0.5))
    return facets.mesh(Texture(np.full((2, 2, 3), 128, np.uint8)))


def at(ahead_m: float, left_m: float = 0.0, up_m: float = 1.0) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, 3] = ahead_m, left_m, up_m
    return pose


def seen(
    meshes: list[TexturedMesh], poses: list[NDArray[np.float64]], ids: NDArray[np.int32], hiders: tuple[int, ...] = ()
) -> SeenBody:
    hidden_by = np.array(hiders, dtype=np.int64)
    return seen_body(joined(meshes), np.array(poses), CAMERA, POSE, ids, OWN, hiders=hidden_by)


def everywhere(instance_id: int) -> NDArray[np.int32]:
    return np.full((CAMERA.height_px, CAMERA.width_px), instance_id, np.int32)


def _on_board(width_m: float, height_m: float, pose: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which rays through samples meet an upright board, of a picture with 200 more pixels on each side."""
    columns, rows = np.meshgrid(np.arange(-200, 264), np.arange(-200, 248))
    right, down = (columns + 0.5 - 32) / 60.0, (rows + 0.5 - 24) / 60.0
    x, y, z = pose[:3, 3] - (5e-4, 0, 0)
    return (np.abs(-right * x - y) <= 0.5 * width_m) & (np.abs(1.0 - down * x - z) <= 0.5 * height_m)


@settings(max_examples=60, deadline=None)
@given(ahead=st.floats(1.5, 9.0), left=st.floats(-4.0, 4.0), up=st.floats(-1.0, 3.0), covered=st.integers(0, 48))
def test_one_part_has_the_labels_of_one_body(ahead, left, up, covered):
    # Off the places at which edges and samples coincide, where rounding decides.
    mesh, pose = block((1e-3, 0.9, 1.7)), at(ahead + 0.0137, left + 0.00713, up + 0.00371)
    ids = everywhere(FAR)
    ids[_on_board(0.9, 1.7, pose)[200:248, 200:264]] = OWN
    ids[:covered] = NEAR
    body = seen([mesh], [pose], ids, (NEAR,))
    box = amodal_box(CAMERA, POSE, mesh, pose)
    np.testing.assert_allclose(body.box_xyxy, box, atol=1e-9)
    picture = SimpleNamespace(instance_id=ids, depth_m=np.ones(ids.shape, np.float32))
    share = visible_fraction(picture, CAMERA, POSE, mesh, pose, OWN, box)
    assert body.visible_fraction == pytest.approx(share, abs=0.01)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 9999))
def test_several_parts_cover_what_any_of_them_covers(seed):
    """By brute force: a sample belongs to the body if a ray through it meets one of the upright boards."""
    rng = np.random.default_rng(seed)
    sizes_m, poses = (
        rng.uniform(0.3, 1.2, (3, 2)),
        [at(4.0 + 0.5 * k, *rng.uniform((-1, 0.5), (1, 1.5))) for k in range(3)],
    )
    meshes = [block((1e-3, *size)) for size in sizes_m]
    ids = everywhere(OWN)
    ids[:, : rng.integers(0, 64)] = NEAR
    body = seen(meshes, poses, ids, (FAR, NEAR))
    inside = np.any([_on_board(*size, pose) for size, pose in zip(sizes_m, poses, strict=True)], axis=0)
    own = inside[200:248, 200:264] & (ids == OWN)
    assert body.visible_fraction == pytest.approx(own.sum() / inside.sum(), abs=0.02)
    hidden = inside[200:248, 200:264] & (ids == NEAR)
    assert (body.hidden_by == NEAR) == bool(hidden.any()) or hidden.sum() < 8
    corners = np.concatenate([mesh.vertices_m + pose[:3, 3] for mesh, pose in zip(meshes, poses, strict=True)])
    pixels = project(CAMERA, POSE, corners)[0]
    np.testing.assert_allclose(body.box_xyxy, [*pixels.min(axis=0), *pixels.max(axis=0)], atol=1e-4)


def test_who_hides_most_is_named_among_those_asked_about():
    mesh, pose = block((0.5, 1.0, 1.0)), at(3.0)
    ids = everywhere(OWN)
    ids[20:24], ids[24:30] = NEAR, FAR
    assert seen([mesh], [pose], ids, (NEAR, FAR)).hidden_by == FAR
    assert seen([mesh], [pose], ids, (NEAR,)).hidden_by == NEAR
    assert seen([mesh], [pose], ids).hidden_by == -1
    assert seen([mesh], [pose], everywhere(OWN), (NEAR, FAR)).hidden_by == -1


@pytest.mark.parametrize("seed", range(5))
def test_bounds_enclose_all_vertices_of_a_posed_body_in_its_own_frame(seed):
    rng = np.random.default_rng(seed)
    meshes = [block(tuple(rng.uniform(0.1, 1.0, 3))) for _ in range(4)]
    part_poses, T_world_body = rigid(4, rng), rigid(1, rng)[0]
    bounds = enclosing_bounds(joined(meshes), part_poses, T_world_body)
    to_body = np.linalg.inv(T_world_body) @ part_poses
    places = [mesh.vertices_m @ T[:3, :3].T + T[:3, 3] for mesh, T in zip(meshes, to_body, strict=True)]
    every = np.concatenate(places)
    np.testing.assert_allclose(bounds, [every.min(axis=0), every.max(axis=0)], atol=1e-6)


def rigid(count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return random poses (``count``, 4, 4)."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = Rotation.random(count, rng=rng).as_matrix()
    poses[:, :3, 3] = rng.uniform(-3.0, 3.0, (count, 3))
    return poses


def test_a_part_behind_the_camera_leaves_nothing_to_say():
    body = seen([block((0.5, 0.5, 0.5))] * 2, [at(3.0), at(-3.0)], everywhere(OWN), (NEAR,))
    assert np.isnan(body.box_xyxy).all()
    assert (body.visible_fraction, body.hidden_by) == (0.0, -1)


def test_a_body_beside_the_picture_has_a_box_and_is_not_seen():
    body = seen([block((0.5, 0.5, 0.5))], [at(3.0, 9.0)], everywhere(OWN), (NEAR,))
    assert body.box_xyxy[2] < 0
    assert (body.visible_fraction, body.hidden_by) == (0.0, -1)


@pytest.mark.parametrize(("ahead_m", "is_told"), [(1.0, True), (0.3, True), (0.24, False), (0.1 + 2e-6, False)])
def test_who_all_but_touches_the_camera_is_not_reckoned_as_large_as_a_house(ahead_m, is_told):
    body = seen([block((0.2, 2.0, 2.0))], [at(ahead_m)], everywhere(OWN))
    assert np.isfinite(body.box_xyxy).all() == is_told
    assert (body.visible_fraction > 0) == is_told


@pytest.mark.parametrize("shape", [(1, 1), (5, 13), (48, 64), (3, 65)])
def test_parts_become_their_bodies_and_all_else_stays(shape):
    rng = np.random.default_rng(4)
    ids = rng.integers(-1, 12, shape).astype(np.int32)
    whole = np.array([0, 1, 2, 3, 4, 4, 4, 7, 7, 7, 7, 7], np.int32)
    merged = ids.copy()
    merge_parts(merged, whole, 4)
    np.testing.assert_array_equal(merged, np.where(ids < 4, ids, whole[ids]))


def test_bodies_together_have_the_labels_of_each_alone():
    turned = np.eye(4)
    turned[:3, :3] = Rotation.from_euler("zyx", (0.7, 0.2, -0.1)).as_matrix()
    bodies = [
        ([block((0.5, 1.0, 1.0))], [at(4.0) @ turned]),
        ([block((0.2, 0.4, 1.2)), block((0.3, 0.3, 0.3))], [at(3.0, 0.6) @ turned, at(3.0, 0.7, 1.8)]),
        ([block((0.5, 1.0, 1.0))], [at(0.1)]),
        ([block((0.5, 0.5, 0.5))], [at(5.0, 30.0)]),
    ]
    ids, shapes = everywhere(-1), [joined(meshes) for meshes, _ in bodies]
    ids[:, :20], ids[:, 20:] = 1, 0
    poses = [np.array(each) for _, each in bodies]
    boxes, fractions, bounds = seen_bodies(shapes, poses, CAMERA, POSE, ids, np.arange(4))
    for k, shape in enumerate(shapes):
        alone = seen_body(shape, poses[k], CAMERA, POSE, ids, k, hiders=np.empty(0, np.int64))
        np.testing.assert_array_equal(boxes[k], alone.box_xyxy)
        assert fractions[k] == alone.visible_fraction
        np.testing.assert_allclose(bounds[k], enclosing_bounds(shape, poses[k], poses[k][0]), atol=1e-12)
    assert 0.0 < fractions[1] < 1.0
    assert np.isnan(boxes[2]).all()
