"""Meshes from files that trimesh has written: sizes, axes, colours, what is refused, and both renderers."""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from sim.mesh import TexturedMesh
from sim.meshes.file import MOST_TRIANGLES, MeshFile, digest_of_files, mesh_of_file, names_mesh_file
from sim.meshes.vehicle import OWN, class_of, kind_of, vehicle
from sim.pose import pose_on_ground
from sim.render.protocol import create_renderer
from sim.world import World
from tests.sim.meshes.mesh_checks import require_closed, require_sound, texels
from tests.sim.ray_casting import away_from_edges
from trackers.types import CameraModel

ANY = (0.0, 1e6)
RED, BLUE = (200, 30, 20, 255), (20, 40, 190, 255)


def lorry(path: Path, up: str = "y") -> str:
    """Write a lorry of two boxes, 8 x 2.5 x 3 m, its cab red and ahead; return the file."""
    cab = trimesh.creation.box((2.0, 2.5, 2.2), trimesh.transformations.translation_matrix((3.0, 0.0, 1.1)))
    load = trimesh.creation.box((6.0, 2.5, 3.0), trimesh.transformations.translation_matrix((-1.0, 0.0, 1.5)))
    for box, rgba in ((cab, RED), (load, BLUE)):
        box.visual.face_colors = rgba
        if up == "y":
            # x ahead, y left, z up are z, x, y there.
            box.apply_transform(np.array([[0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]]))
    trimesh.Scene([cab, load]).export(path)
    return str(path)


def colour_above(mesh: TexturedMesh, x: float) -> tuple[int, ...]:
    shape = trimesh.Trimesh(mesh.vertices_m, mesh.faces, process=False)
    where, _, face = shape.ray.intersects_location([[x, 0.01, 50.0]], [[0.0, 0.0, -1.0]])
    return tuple(texels(mesh)[face[np.argmax(where[:, 2])]].tolist())


@pytest.mark.parametrize("ending", ["glb", "ply"])
def test_a_file_stands_on_the_ground_and_looks_ahead_in_its_colours(tmp_path: Path, ending: str):
    mesh = mesh_of_file(lorry(tmp_path / f"lorry.{ending}", "y" if ending == "glb" else "z"), (1.0, 20.0))
    require_sound(mesh)
    require_closed(mesh)
    np.testing.assert_allclose(mesh.size_m, (8.0, 2.5, 3.0), atol=1e-5)
    np.testing.assert_allclose(mesh.bounds_m[0], (-4.0, -1.25, 0.0), atol=1e-5)
    assert not mesh.texture.smooth
    assert colour_above(mesh, 3.0) == RED[:3]
    assert colour_above(mesh, -2.0) == BLUE[:3]


def test_options_scale_raise_and_turn(tmp_path: Path):
    trimesh.creation.box((250.0, 800.0, 300.0)).export(tmp_path / "box.stl")
    mesh = mesh_of_file(f"{tmp_path}/box.stl@scale=0.01@yaw=-90", ANY)
    np.testing.assert_allclose(mesh.size_m, (8.0, 2.5, 3.0), atol=1e-4)
    mesh = mesh_of_file(f"{tmp_path}/box.stl@scale=0.01@up=y", ANY)
    np.testing.assert_allclose(mesh.size_m, (3.0, 2.5, 8.0), atol=1e-4)


def painted_board(path: Path) -> str:
    """Write a board of 4 x 2 m in the plane, whose picture is red on the left and blue on the right."""
    corners = [[0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]]
    picture = np.zeros((32, 64, 3), np.uint8)
    picture[:, :32], picture[:, 32:] = RED[:3], BLUE[:3]
    visual = trimesh.visual.TextureVisuals(
        uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
        material=trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(picture)),
    )
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], visual=visual, process=False).export(path)
    return f"{path}@up=z"


@pytest.mark.parametrize("ending", ["glb", "obj"])
def test_a_picture_lies_where_the_file_puts_it(tmp_path: Path, ending: str):
    mesh = mesh_of_file(painted_board(tmp_path / f"board.{ending}"), ANY)
    assert mesh.texture.smooth
    rows, columns = mesh.texture.rgb.shape[:2]
    for x, rgb in ((-1.5, RED), (1.5, BLUE)):
        share = (x + 2.0) / 4.0
        left, right = (mesh.uv[np.isclose(mesh.vertices_m[:, 0], side)].mean(axis=0) for side in (-2.0, 2.0))
        u, v = left + share * (right - left)
        assert np.abs(mesh.texture.rgb[int(v * rows), int(u * columns)].astype(int) - rgb[:3]).max() < 12


def test_a_robot_stands_with_its_joints_at_rest(tmp_path: Path):
    lorry(tmp_path / "cab.stl", "z")
    (tmp_path / "robot.urdf").write_text(
        """<robot name="r"><material name="m"><color rgba="1 0 0 1"/></material>
        <link name="base"><visual><geometry><box size="4 2 1"/></geometry><material name="m"/></visual></link>
        <link name="mast"><visual><origin xyz="0 0 1"/><geometry><cylinder radius="0.2" length="2"/></geometry></visual>
        </link><joint name="j" type="revolute"><parent link="base"/><child link="mast"/><origin xyz="1 0 0.5"/></joint>
        </robot>"""
    )
    mesh = mesh_of_file(f"{tmp_path}/robot.urdf", ANY)
    np.testing.assert_allclose(mesh.size_m, (4.0, 2.0, 3.0), atol=1e-5)
    assert colour_above(mesh, -1.0) == (255, 0, 0)
    (tmp_path / "far.urdf").write_text(
        '<robot name="r"><link name="l"><visual><geometry><mesh filename="package://any/cab.stl"/></geometry></visual>'
        "</link></robot>"
    )
    assert mesh_of_file(f"{tmp_path}/far.urdf", ANY).size_m[0] == pytest.approx(8.0)


def test_what_cannot_be_drawn_is_named(tmp_path: Path):
    file = lorry(tmp_path / "lorry.glb")
    with pytest.raises(ValueError, match=r"mesh: expected a file that exists, got .*gone\.glb"):
        mesh_of_file(str(tmp_path / "gone.glb"), ANY)
    with pytest.raises(ValueError, match=r"longest side of 0\.5 to 5 m, got 8 x 2\.5 x 3 m; .*@scale=0\.01"):
        mesh_of_file(file, (0.5, 5.0))
    with pytest.raises(ValueError, match=r"with @scale=NUMBER, @up=y or z"):
        mesh_of_file(f"{file}@size=3", ANY)
    with pytest.raises(ValueError, match=r"mesh @scale: expected a number, got"):
        mesh_of_file(f"{file}@scale=-1", ANY)
    (tmp_path / "broken.glb").write_bytes(b"no mesh at all, but long enough to have a header")
    with pytest.raises(ValueError, match=r"a glb file that can be read, got broken\.glb"):
        mesh_of_file(f"{tmp_path}/broken.glb", ANY)
    (tmp_path / "empty.obj").write_text("v 0 0 0\n")
    with pytest.raises(ValueError, match=r"mesh: expected .*got empty\.obj"):
        mesh_of_file(f"{tmp_path}/empty.obj", ANY)
    for uri, said in (("https://x.org/a.bin", "as nothing is fetched"), ("a.bin", "the file that far.gltf names")):
        (tmp_path / "far.gltf").write_text(json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": uri}]}))
        with pytest.raises(ValueError, match=said):
            mesh_of_file(f"{tmp_path}/far.gltf", ANY)
    (tmp_path / "bare.obj").write_text("mtllib bare.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ValueError, match=r"the file that bare\.obj names, got 'bare\.mtl'"):
        mesh_of_file(f"{tmp_path}/bare.obj", ANY)


def test_too_many_triangles_are_refused(tmp_path: Path):
    side = int(np.sqrt(MOST_TRIANGLES / 2)) + 2
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    corners = np.column_stack([x.ravel(), y.ravel(), np.zeros(side * side)])
    first = (side * np.arange(side - 1)[:, None] + np.arange(side - 1)).ravel()
    faces = np.concatenate([np.stack(each, 1) for each in ((first, first + 1, first + side),) * 2])
    trimesh.Trimesh(corners, faces, process=False).export(tmp_path / "fine.ply")
    with pytest.raises(
        ValueError, match=r"at most 100000 triangles \(Blender's Decimate makes fewer\), got \d+ in fine"
    ):
        mesh_of_file(f"{tmp_path}/fine.ply", ANY)


def test_a_changed_file_is_read_again_and_has_another_digest(tmp_path: Path):
    file = lorry(tmp_path / "lorry.glb")
    before = digest_of_files([file, "sedan"])
    assert before
    assert digest_of_files(["sedan", "any"]) == ""
    assert digest_of_files([f"{file}@scale=0.9"]) != before
    time.sleep(0.01)
    trimesh.creation.box((2.0, 2.0, 6.0)).export(file)
    assert digest_of_files([file]) != before
    np.testing.assert_allclose(mesh_of_file(file, ANY).size_m, (6.0, 2.0, 2.0), atol=1e-5)


def test_a_file_is_a_vehicle_of_the_kind_that_it_says(tmp_path: Path):
    file = lorry(tmp_path / "lorry.glb")
    np.testing.assert_allclose(vehicle(file, (0, 0, 0)).size_m, (8.0, 2.5, 3.0), atol=1e-5)
    assert (kind_of(file), class_of(file)) == ("lorry", "lorry")
    assert (kind_of("x/cart.glb"), class_of("x/cart.glb"), kind_of("x/cart.glb@kind=bus")) == (OWN, "car", "bus")
    assert names_mesh_file("x/cart.GLB@scale=2")
    assert not names_mesh_file("sedan")
    assert MeshFile.of("cart.obj").up == "y"
    with pytest.raises(ValueError, match=r"longer than wide, as .*@yaw=90"):
        vehicle(f"{file}@yaw=90", (0, 0, 0))
    with pytest.raises(ValueError, match=r"mesh @kind: expected one of sedan"):
        kind_of("x/cart.glb@kind=cart")


def test_both_renderers_draw_a_file_alike(tmp_path: Path):
    world = World()
    world.add(
        mesh_of_file(lorry(tmp_path / "lorry.glb"), ANY),
        pose_on_ground(1.0, 0.5, 0.4),
        name="lorry",
        category="vehicle",
    )
    camera = CameraModel.from_field_of_view(160, 120, np.radians(50))
    T_world_camera = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 14.0], [0, 0, 0, 1.0]])
    raster, reference = (
        create_renderer(name, world).gbuffer(camera, T_world_camera, pixel_offset=0.0)
        for name in ("raster", "pybullet")
    )
    differs = raster.instance_id != reference.instance_id
    assert (raster.instance_id >= 0).mean() > 0.1
    assert differs.mean() < 2e-3
    assert not (differs & away_from_edges(raster.instance_id)).any()
    seen = ~differs & (raster.instance_id >= 0)
    assert (raster.base_colour_rgb == reference.base_colour_rgb).all(axis=-1)[seen].mean() > 0.98
