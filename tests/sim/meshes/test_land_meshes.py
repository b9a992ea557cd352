"""The land: textures lie where they should, tiles meet without a seam, kerbs follow their curve."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.mesh import Texture
from sim.meshes.ground import ground, kerb, surroundings
from tests.sim.meshes.mesh_checks import require_sound, welded

PLAIN = Texture(np.full((8, 8, 3), 120, dtype=np.uint8), smooth=True)


def test_the_ground_shows_its_texture_once_with_the_top_left_corner_in_the_north_west() -> None:
    mesh = ground(50.0, PLAIN)
    require_sound(mesh)
    assert (mesh.normals == (0, 0, 1)).all()
    np.testing.assert_allclose(mesh.uv[:, 0], mesh.vertices_m[:, 0] / 50.0 + 0.5, atol=1e-6)
    np.testing.assert_allclose(mesh.uv[:, 1], 0.5 - mesh.vertices_m[:, 1] / 50.0, atol=1e-6)
    assert welded(mesh).area == pytest.approx(2500.0, rel=1e-6)


@pytest.mark.parametrize(("outer_m", "side_m"), [(120.0, 150.0), (150.0, 150.0), (200.0, 250.0)])
def test_the_surroundings_leave_out_the_ground_and_go_on_without_a_seam(outer_m: float, side_m: float) -> None:
    mesh = surroundings(50.0, outer_m, PLAIN, _flat)
    require_sound(mesh)
    np.testing.assert_allclose(mesh.size_m, (side_m, side_m, 0.0), atol=1e-4)
    assert welded(mesh).area == pytest.approx(side_m**2 - 50.0**2, rel=1e-5)
    middle = mesh.vertices_m[mesh.faces].mean(axis=1)
    assert (np.abs(middle[:, :2]).max(axis=1) > 25.0).all()
    # Corners at the same place have the same place in the texture, whichever tile they belong to.
    at = np.round(mesh.vertices_m, 3)
    for _, group in _grouped(at, mesh.uv):
        np.testing.assert_allclose(np.ptp(group, axis=0), 0.0, atol=1e-5)


def _flat(x: NDArray[np.float64], _: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros_like(x)


def _grouped(keys: NDArray[np.float32], values: NDArray[np.float32]) -> list[tuple[bytes, NDArray[np.float32]]]:
    groups: dict[bytes, list[NDArray[np.float32]]] = {}
    for key, value in zip(keys + 0.0, values, strict=True):
        groups.setdefault(key.tobytes(), []).append(value)
    return [(key, np.array(group)) for key, group in groups.items()]


def test_impossible_land_is_named() -> None:
    with pytest.raises(ValueError, match="extent_m: expected a length > 0 m, got -1"):
        ground(-1, PLAIN)
    with pytest.raises(ValueError, match=r"outer_m: expected more than extent_m = 50.0, got 50.0"):
        surroundings(50.0, 50.0, PLAIN, _flat)


def test_a_kerb_follows_its_curve_and_keeps_its_width() -> None:
    angle = np.linspace(0.0, 1.5, 60)
    mesh = kerb(20.0 * np.column_stack([np.cos(angle), np.sin(angle)]), 0.2, 0.1, (190, 188, 180), bevel_m=0.02)
    require_sound(mesh)
    from_centre = np.linalg.norm(mesh.vertices_m[:, :2], axis=1)
    foot = mesh.vertices_m[:, 2] < 0.05
    np.testing.assert_allclose(np.abs(from_centre - 20.0), np.where(foot, 0.1, 0.08), atol=0.01)
    assert set(np.round(mesh.vertices_m[:, 2], 6).tolist()) == {0.0, np.float32(0.1).round(6).item()}
    top = mesh.normals[:, 2] > 0.99
    assert (mesh.vertices_m[top, 2] > 0.09).all()
    # Simplified, but by no more than the tolerance: the top's area is that of the ring.
    upper = welded(mesh).area_faces[np.asarray(welded(mesh).face_normals)[:, 2] > 0.99].sum()
    assert upper == pytest.approx(0.16 * 20.0 * 1.5, rel=0.01)
    assert len(mesh.faces) < 6 * 59


def test_an_impossible_kerb_is_named() -> None:
    with pytest.raises(ValueError, match=r"polyline_m: expected at least two points \(n, 2\), got shape \(1, 2\)"):
        kerb(np.zeros((1, 2)), 0.2, 0.1, (190, 188, 180), bevel_m=0.02)
    with pytest.raises(ValueError, match="height_m: expected a length > 0 m, got 0"):
        kerb(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.2, 0.0, (190, 188, 180), bevel_m=0.02)
    for bevel_m in (0.0, 0.1):
        with pytest.raises(ValueError, match=r"bevel_m: expected a length in \(0, 0.1\) m"):
            kerb(np.array([[0.0, 0.0], [1.0, 0.0]]), 0.2, 0.1, (190, 188, 180), bevel_m=bevel_m)


def test_a_kerb_has_no_upright_face():
    mesh = kerb(np.array([[0.0, 0.0], [9.0, 0.0]]), 0.3, 0.04, (190, 188, 180), bevel_m=0.1)
    assert mesh.normals[:, 2].min() > 0.9
    assert np.ptp(mesh.vertices_m[:, 1]) == pytest.approx(0.3)
    assert mesh.vertices_m[:, 2].max() == pytest.approx(0.04)
