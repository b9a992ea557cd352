"""Containers have their standard size; cranes stand on the ground; hills close the horizon."""

from __future__ import annotations

import numpy as np
import pytest

from sim.meshes.quayside import CONTAINER_M, CRANE_PARTS, container, portal_crane, skyline
from sim.rng import generator


def test_a_container_has_its_size_and_stands_on_its_floor() -> None:
    mesh = container(generator(1, "box"))
    np.testing.assert_allclose(mesh.size_m, CONTAINER_M, atol=1e-5)
    assert mesh.vertices_m[:, 2].min() == pytest.approx(0.0)


@pytest.mark.parametrize("turn_rad", [-2.0, 0.0, 1.3])
def test_a_crane_stands_on_four_legs_and_its_jib_reaches_out(turn_rad: float) -> None:
    mesh = portal_crane(10.0, 14.0, turn_rad)
    low = mesh.vertices_m[mesh.vertices_m[:, 2] < 0.5]
    assert mesh.vertices_m[:, 2].min() == pytest.approx(0.0)
    assert {tuple(np.sign(each).tolist()) for each in low[:, :2]} == {(1, 1), (1, -1), (-1, 1), (-1, -1)}
    ahead = np.array([np.cos(turn_rad), np.sin(turn_rad)])
    assert (mesh.vertices_m[:, :2] @ ahead).max() == pytest.approx(14.0, abs=0.5)
    assert len(np.unique(mesh.texture.rgb[..., 0])) == len(CRANE_PARTS)


def test_hills_stand_all_round_and_face_inwards() -> None:
    heights = 20.0 + 5.0 * np.cos(np.arange(24))
    mesh = skyline(900.0, heights, -3.0)
    assert mesh.vertices_m[:, 2].max() == pytest.approx(heights.max(), abs=1e-4)
    outward = (mesh.vertices_m[:, :2] * mesh.normals[:, :2]).sum(axis=1)
    assert (outward < 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices_m[:, :2], axis=1), 900.0, rtol=1e-5)
