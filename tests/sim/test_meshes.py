"""Shapes: closed, turned outwards, of the promised size, the same for the same generator, each in its colours."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import KDTree

from sim.mesh import Texture, TexturedMesh
from sim.meshes import vehicle as vehicle_module
from sim.meshes.car_parts import Swatch, colour
from sim.meshes.facets import Facets
from sim.meshes.ground import ground, kerb, surroundings
from sim.meshes.house import OVERHANG_M, PARAPET_M, ROOFS, house
from sim.meshes.tree import tree
from sim.meshes.vehicle import VEHICLES, vehicle, vehicle_model

RED, BLUE = (176, 24, 26), (28, 62, 150)
WALL, TILES = (214, 204, 186), (142, 68, 52)
PLAIN = Texture(np.full((8, 8, 3), 120, dtype=np.uint8), smooth=True)

seeds = st.integers(0, 10_000)


def rng_of(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def welded(mesh: TexturedMesh) -> trimesh.Trimesh:
    """Return the shape with corners at the same place made one."""
    shape = trimesh.Trimesh(mesh.vertices_m, mesh.faces, process=False)
    shape.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=4)
    return shape


def parts(mesh: TexturedMesh) -> list[trimesh.Trimesh]:
    return list(welded(mesh).split(only_watertight=False))


def require_sound(mesh: TexturedMesh) -> None:
    """Types, ranges, and normals that are those of the faces."""
    assert (mesh.vertices_m.dtype, mesh.normals.dtype, mesh.uv.dtype) == (np.float32,) * 3
    assert mesh.faces.dtype == np.int32
    assert len(mesh.vertices_m) == len(mesh.normals) == len(mesh.uv)
    assert mesh.uv.min() >= 0.0
    assert mesh.uv.max() <= 1.0
    a, b, c = np.moveaxis(mesh.vertices_m[mesh.faces].astype(float), 1, 0)
    area = np.cross(b - a, c - a)
    doubled = np.linalg.norm(area, axis=1)
    assert doubled.min() > 1e-6
    for corner in range(3):
        cosine = (mesh.normals[mesh.faces[:, corner]] * area).sum(axis=1) / doubled
        assert cosine.min() > 0.999


def require_closed(mesh: TexturedMesh) -> None:
    """Every edge is walked as often one way as the other, and every part holds a volume, not a hollow."""
    faces = np.asarray(welded(mesh).faces)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there = {tuple(e): n for e, n in zip(*np.unique(edges, axis=0, return_counts=True), strict=True)}
    assert all(there.get(edge[::-1]) == n for edge, n in there.items())
    assert min(part.volume for part in parts(mesh)) > 0.0


def texels(mesh: TexturedMesh) -> NDArray[np.uint8]:
    """Return the colour (F, 3) that nearest sampling finds in the middle of every face."""
    rows, columns = mesh.texture.rgb.shape[:2]
    u, v = mesh.uv[mesh.faces].mean(axis=1).T
    return mesh.texture.rgb[(v * rows).astype(int), (u * columns).astype(int)]


def colour_at(mesh: TexturedMesh, x: float, y: float) -> tuple[int, ...]:
    """Return the colour seen from straight above a place, by ray casting."""
    shape = trimesh.Trimesh(mesh.vertices_m, mesh.faces, process=False)
    where, _, face = shape.ray.intersects_location([[x, y, 50.0]], [[0.0, 0.0, -1.0]])
    return tuple(texels(mesh)[face[np.argmax(where[:, 2])]].tolist())


@pytest.mark.parametrize("model", VEHICLES)
def test_a_car_is_a_closed_shape_of_a_cars_size_under_the_middle_of_its_bounds(model: str) -> None:
    mesh = vehicle(model, RED)
    require_sound(mesh)
    require_closed(mesh)
    length, width, height = mesh.size_m
    assert 3.8 <= length <= 5.4
    assert 1.7 <= width <= 2.05
    assert 1.4 <= height <= 2.3
    low, high = mesh.vertices_m.min(axis=0), mesh.vertices_m.max(axis=0)
    np.testing.assert_allclose(low[:2] + high[:2], 0.0, atol=1e-5)
    assert low[2] == pytest.approx(0.0, abs=1e-6)
    to_mirrored_m, _ = KDTree(mesh.vertices_m).query(mesh.vertices_m * (1, -1, 1))
    assert to_mirrored_m.max() < 1e-4


@pytest.mark.parametrize("model", VEHICLES)
def test_a_car_has_lamps_before_and_behind_and_glass_before_its_roof(model: str) -> None:
    mesh = vehicle(model, RED)
    swatch = np.floor(mesh.uv[mesh.faces[:, 0], 0] * len(Swatch)).astype(int)
    middle = mesh.vertices_m[mesh.faces].mean(axis=1)
    half = 0.5 * mesh.size_m[0]
    assert (middle[swatch == Swatch.LIGHT, 0] > 0.8 * half).all()
    assert (middle[swatch == Swatch.RED, 0] < -0.8 * half).all()
    assert {Swatch.LIGHT, Swatch.RED, Swatch.GLASS, Swatch.LIGHT_PAINT} <= set(swatch)
    roof = middle[swatch == Swatch.LIGHT_PAINT]
    windscreen = (swatch == Swatch.GLASS) & (mesh.normals[mesh.faces[:, 0], 0] > 0.3)
    assert middle[windscreen, 0].min() > roof[:, 0].max()
    # Tyres touch the ground and nothing else does.
    assert set(swatch[mesh.vertices_m[mesh.faces][..., 2].min(axis=1) < 0.05]) <= {Swatch.BLACK}


def test_seen_from_above_a_car_shows_paint_then_glass_then_roof() -> None:
    mesh = vehicle("sedan", RED)
    bonnet, windscreen, roof = (colour_at(mesh, x, 0.05) for x in (1.5, 0.65, -0.3))
    assert bonnet == RED
    assert max(windscreen) < 60
    assert roof[0] > RED[0]
    assert roof[0] > roof[1] + 80


def test_the_bed_of_a_pickup_is_open() -> None:
    assert max(colour_at(vehicle("pickup", RED), -1.6, 0.05)) < 40


def test_cars_share_a_shape_of_one_model_and_a_texture_of_one_paint() -> None:
    red, blue, other = vehicle("sedan", RED), vehicle("sedan", BLUE), vehicle("suv", RED)
    assert red.vertices_m is blue.vertices_m
    assert red.texture is other.texture
    assert not np.array_equal(texels(red), texels(blue))
    # What is not painted stays as it is.
    unpainted = np.all(texels(red) == texels(blue), axis=1)
    assert 0.3 < unpainted.mean() < 0.8


@pytest.mark.parametrize("paint", [(256, 0, 0), (-1, 0, 0), (1, 2)])
def test_an_impossible_paint_is_named(paint: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"paint_rgb: expected three numbers from 0 to 255, got \("):
        vehicle("sedan", paint)  # type: ignore[arg-type]


def test_an_unknown_model_is_named() -> None:
    with pytest.raises(ValueError, match=r"model: expected one of sedan, .*pickup, got 'tank'"):
        vehicle("tank", RED)


def test_a_user_adds_a_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vehicle_module, "VEHICLES", dict(VEHICLES))

    @vehicle_model("brick")
    def _brick(facets: Facets) -> None:
        facets.box((0.0, -0.9, 0.2), (4.0, 0.9, 1.5), colour(Swatch.PAINT))

    mesh = vehicle("brick", BLUE)
    np.testing.assert_allclose(mesh.size_m, (4.0, 1.8, 1.3), atol=1e-6)
    np.testing.assert_allclose(mesh.vertices_m.min(axis=0), (-2.0, -0.9, 0.0), atol=1e-6)
    assert set(map(tuple, texels(mesh).tolist())) == {BLUE}
    with pytest.raises(ValueError, match="name: expected one that is not taken yet, got 'brick'"):
        vehicle_model("brick")(_brick)


@settings(max_examples=40, deadline=None)
@given(
    seed=seeds,
    roof=st.sampled_from(ROOFS),
    length=st.floats(6.0, 40.0),
    width=st.floats(5.0, 25.0),
    eaves=st.floats(2.5, 14.0),
)
def test_a_house_is_closed_and_keeps_to_its_size(
    seed: int, roof: str, length: float, width: float, eaves: float
) -> None:
    mesh = house((length, width, eaves), roof, WALL, TILES, rng_of(seed))
    require_sound(mesh)
    require_closed(mesh)
    assert len(mesh.faces) <= 120
    out = OVERHANG_M if roof != "flat" else 0.03
    np.testing.assert_allclose(mesh.size_m[:2], (length + 2 * out, width + 2 * out), atol=1e-3)
    np.testing.assert_allclose(mesh.vertices_m[:, :2].min(0) + mesh.vertices_m[:, :2].max(0), 0.0, atol=1e-3)
    assert mesh.vertices_m[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    if roof == "flat":
        assert eaves + PARAPET_M - 1e-3 <= mesh.size_m[2] <= eaves + 1.4
    else:
        assert eaves + 0.8 < mesh.size_m[2] < eaves + 6.5


@pytest.mark.parametrize("roof", ROOFS)
def test_seen_from_above_a_house_is_its_roof(roof: str) -> None:
    """Ray casting on a grid inside the parapet: what stands on the roof covers less than half of it."""
    mesh = house((14.0, 9.0, 5.0), roof, (230, 230, 230), (150, 40, 30), rng_of(3))
    places = [(x, y) for x in np.linspace(-6.5, 6.5, 9) for y in np.linspace(-4.0, 4.0, 6)]
    seen = np.array([colour_at(mesh, x, y) for x, y in places])
    reddish = seen[:, 0] > 2 * seen[:, 1]
    assert reddish.mean() > 0.5


def test_long_and_deep_houses_are_turned_alike() -> None:
    """A house deeper than it is long is the other one turned by a quarter."""
    a = house((9.0, 14.0, 5.0), "gable", WALL, TILES, rng_of(1))
    b = house((14.0, 9.0, 5.0), "gable", WALL, TILES, rng_of(1))
    np.testing.assert_allclose(a.vertices_m, b.vertices_m[:, [1, 0, 2]] * (-1, 1, 1), atol=1e-6)
    np.testing.assert_array_equal(a.texture.rgb, b.texture.rgb)


def test_houses_differ_by_generator_and_not_otherwise() -> None:
    for roof in ROOFS:
        one, same, other = (house((12.0, 9.0, 5.0), roof, WALL, TILES, rng_of(seed)) for seed in (1, 1, 2))
        np.testing.assert_array_equal(one.vertices_m, same.vertices_m)
        np.testing.assert_array_equal(one.texture.rgb, same.texture.rgb)
        assert not np.array_equal(one.texture.rgb, other.texture.rgb)


def test_an_impossible_house_is_named() -> None:
    with pytest.raises(ValueError, match="roof: expected one of flat, gable, hip, got 'dome'"):
        house((12.0, 9.0, 5.0), "dome", WALL, TILES, rng_of(1))
    with pytest.raises(ValueError, match="size_m: expected three lengths > 0 m, got"):
        house((12.0, -9.0, 5.0), "flat", WALL, TILES, rng_of(1))


@settings(max_examples=25, deadline=None)
@given(seed=seeds, radius=st.floats(0.5, 6.0), slender=st.floats(1.2, 5.0))
def test_a_tree_stands_on_its_trunk_and_keeps_to_its_size(seed: int, radius: float, slender: float) -> None:
    height = radius * slender
    mesh = tree(radius, height, rng_of(seed))
    require_sound(mesh)
    require_closed(mesh)
    assert len(mesh.faces) <= 180
    assert mesh.vertices_m[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert mesh.vertices_m[:, 2].max() == pytest.approx(height, rel=1e-5)
    assert np.linalg.norm(mesh.vertices_m[:, :2], axis=1).max() == pytest.approx(radius, rel=1e-5)
    again = tree(radius, height, rng_of(seed))
    np.testing.assert_array_equal(mesh.vertices_m, again.vertices_m)
    np.testing.assert_array_equal(mesh.uv, again.uv)
    assert mesh.texture is again.texture


def test_a_crown_shows_many_greens_and_no_bark() -> None:
    mesh = tree(3.0, 8.0, rng_of(0))
    low_m = mesh.vertices_m[mesh.faces][..., 2].min(axis=1)
    crown = texels(mesh)[low_m > 2.2].astype(int)
    assert len(crown) > 120
    assert (crown[:, 1] >= crown[:, 2]).mean() > 0.95
    assert crown[:, 1].std() > 6.0


def test_an_impossible_tree_is_named() -> None:
    with pytest.raises(ValueError, match=r"radius_m: expected a length > 0 m, got 0"):
        tree(0, 3.0, rng_of(1))
    with pytest.raises(ValueError, match=r"height_m: expected more than radius_m = 3.0, got 2.0"):
        tree(3.0, 2.0, rng_of(1))


def test_the_ground_shows_its_texture_once_with_the_top_left_corner_in_the_north_west() -> None:
    mesh = ground(50.0, PLAIN)
    require_sound(mesh)
    assert (mesh.normals == (0, 0, 1)).all()
    np.testing.assert_allclose(mesh.uv[:, 0], mesh.vertices_m[:, 0] / 50.0 + 0.5, atol=1e-6)
    np.testing.assert_allclose(mesh.uv[:, 1], 0.5 - mesh.vertices_m[:, 1] / 50.0, atol=1e-6)
    assert welded(mesh).area == pytest.approx(2500.0, rel=1e-6)


@pytest.mark.parametrize(("outer_m", "side_m"), [(120.0, 150.0), (150.0, 150.0), (200.0, 250.0)])
def test_the_surroundings_leave_out_the_ground_and_go_on_without_a_seam(outer_m: float, side_m: float) -> None:
    mesh = surroundings(50.0, outer_m, PLAIN)
    require_sound(mesh)
    np.testing.assert_allclose(mesh.size_m, (side_m, side_m, 0.0), atol=1e-4)
    assert welded(mesh).area == pytest.approx(side_m**2 - 50.0**2, rel=1e-5)
    middle = mesh.vertices_m[mesh.faces].mean(axis=1)
    assert (np.abs(middle[:, :2]).max(axis=1) > 25.0).all()
    # Corners at the same place have the same place in the texture, whichever tile they belong to.
    at = np.round(mesh.vertices_m, 3)
    for _, group in _grouped(at, mesh.uv):
        np.testing.assert_allclose(np.ptp(group, axis=0), 0.0, atol=1e-5)


def _grouped(keys: NDArray[np.float32], values: NDArray[np.float32]) -> list[tuple[bytes, NDArray[np.float32]]]:
    groups: dict[bytes, list[NDArray[np.float32]]] = {}
    for key, value in zip(keys + 0.0, values, strict=True):
        groups.setdefault(key.tobytes(), []).append(value)
    return [(key, np.array(group)) for key, group in groups.items()]


def test_impossible_land_is_named() -> None:
    with pytest.raises(ValueError, match="extent_m: expected a length > 0 m, got -1"):
        ground(-1, PLAIN)
    with pytest.raises(ValueError, match=r"outer_m: expected more than extent_m = 50.0, got 50.0"):
        surroundings(50.0, 50.0, PLAIN)


def test_a_kerb_follows_its_curve_and_keeps_its_width() -> None:
    angle = np.linspace(0.0, 1.5, 60)
    mesh = kerb(20.0 * np.column_stack([np.cos(angle), np.sin(angle)]), 0.2, 0.1, (190, 188, 180))
    require_sound(mesh)
    from_centre = np.linalg.norm(mesh.vertices_m[:, :2], axis=1)
    np.testing.assert_allclose(np.abs(from_centre - 20.0), 0.1, atol=0.01)
    assert set(np.round(mesh.vertices_m[:, 2], 6).tolist()) == {0.0, np.float32(0.1).round(6).item()}
    top = mesh.normals[:, 2] > 0.99
    assert (mesh.vertices_m[top, 2] > 0.09).all()
    # Simplified, but by no more than the tolerance: the top's area is that of the ring.
    upper = welded(mesh).area_faces[np.asarray(welded(mesh).face_normals)[:, 2] > 0.99].sum()
    assert upper == pytest.approx(0.2 * 20.0 * 1.5, rel=0.01)
    assert len(mesh.faces) < 6 * 59


def test_an_impossible_kerb_is_named() -> None:
    with pytest.raises(ValueError, match=r"polyline_m: expected at least two points \(n, 2\), got shape \(1, 2\)"):
        kerb(np.zeros((1, 2)), 0.2, 0.1, (190, 188, 180))
    with pytest.raises(ValueError, match="height_m: expected a length > 0 m, got 0"):
        kerb(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.2, 0.0, (190, 188, 180))
