"""Shapes and looks of fish: closed segments that overlap where they bend, of their size, in their colours."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.meshes.fish import SPECIES, TAIL_REACH, FishLook, draw_look, fish_segments, half_size
from sim.motion.swim import JOINT_COUNT, SEGMENT_COUNT, SEGMENT_ENDS, swim_pose
from tests.sim.meshes.mesh_checks import parts, require_closed

LARGE = FishLook(length_m=0.2)
"""Corners are made one by rounding to 0.1 mm: a small fish would lose some."""


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def in_world(look: FishLook, joints_rad: list[float]) -> list[trimesh.Trimesh]:
    """Return the segments of a fish at the origin as another library's meshes."""
    pose = swim_pose(
        np.array([look.length_m]), np.zeros((1, 3)), np.zeros(1), np.zeros(1), np.array([joints_rad], dtype=float)
    )
    shapes = []
    for mesh, T in zip(fish_segments(look, rng()), pose.T_world_segment[0], strict=True):
        shape = trimesh.Trimesh(mesh.vertices_m, mesh.faces, process=False)
        shapes.append(shape.apply_transform(T))
    return shapes


def test_segments_are_closed_smooth_and_turned_outwards():
    made = fish_segments(LARGE, rng())
    assert len(made) == SEGMENT_COUNT
    assert sum(len(mesh.faces) for mesh in made) < 500
    for mesh in made:
        require_closed(mesh)
        assert (mesh.vertices_m.dtype, mesh.normals.dtype, mesh.uv.dtype) == (np.float32,) * 3
        assert mesh.faces.dtype == np.int32
        assert mesh.uv.min() >= 0.0
        assert mesh.uv.max() <= 1.0
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)
        for part in parts(mesh):
            assert part.is_convex
        # Normals point away from the middle of their own convex piece, so never into it.
        a, b, c = np.moveaxis(mesh.vertices_m[mesh.faces].astype(float), 1, 0)
        area = np.cross(b - a, c - a)
        assert ((mesh.normals[mesh.faces].mean(axis=1) * area).sum(axis=1) > -0.35 * np.linalg.norm(area, axis=1)).all()


def test_a_straight_fish_has_its_length_and_a_plausible_breadth_and_depth():
    look = FishLook(length_m=0.05, width=1.1)
    corners_m = np.concatenate([shape.vertices for shape in in_world(look, [0.0] * JOINT_COUNT)])
    assert np.ptp(corners_m[:, 0]) == pytest.approx(0.05, abs=1e-6)
    assert np.ptp(corners_m[:, 2]) == pytest.approx(2 * TAIL_REACH * 0.05, rel=1e-5)
    middle = corners_m[np.abs(corners_m[:, 0] - 0.01) < 0.01]
    assert 0.15 * 0.05 < np.ptp(middle[:, 1]) < 0.4 * 0.05


@given(st.lists(st.floats(-0.5, 0.5), min_size=JOINT_COUNT, max_size=JOINT_COUNT))
@settings(max_examples=25, deadline=None)
def test_a_bent_body_shows_no_cracks_from_above(joints_rad):
    """A disc about a joint, of 0.85 of the half width there, lies inside the two segments whichever way they bend."""
    shapes = in_world(LARGE, joints_rad)
    for joint in range(JOINT_COUNT):
        behind = shapes[joint + 1]
        centre = swim_pose(
            np.array([LARGE.length_m]), np.zeros((1, 3)), np.zeros(1), np.zeros(1), np.array([joints_rad], dtype=float)
        ).T_world_segment[0, joint + 1, :3, 3]
        radius = 0.85 * np.cos(np.pi / 8) ** 2 * float(half_size(SEGMENT_ENDS[joint + 1])[0]) * LARGE.length_m
        angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        disc = centre + radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
        covered = np.zeros(len(disc), dtype=bool)
        for shape in (shapes[joint], behind):
            for piece in shape.split(only_watertight=False):
                inward = piece.face_normals @ disc.T - (piece.face_normals * piece.triangles[:, 0]).sum(1)[:, None]
                covered |= (inward <= 1e-6).all(axis=0)
        assert covered.all(), joint


def test_back_is_darker_than_flank_and_eyes_are_darkest():
    texture = fish_segments(FishLook(), rng())[2].texture.rgb.astype(float)
    back, flank = texture[26:40, :3].mean(), texture[26:40, 8:14].mean()
    assert back < flank - 30
    head = fish_segments(FishLook(), rng())[0]
    rows, columns = head.texture.rgb.shape[:2]
    u, v = head.uv[head.faces].mean(axis=1).T
    colours = head.texture.rgb[(v * rows).astype(int), np.minimum((u * columns).astype(int), columns - 1)].mean(axis=1)
    darkest = head.vertices_m[head.faces[colours < 30]].reshape(-1, 3)
    assert len(darkest) > 0
    assert np.abs(darkest[:, 1]).min() > 0.0005


def test_spots_darken_the_back_where_they_lie():
    plain = fish_segments(FishLook(), rng())[0].texture.rgb.astype(float)
    spotted = fish_segments(FishLook(spots=((0.5, 0.8),)), rng())[0].texture.rgb.astype(float)
    difference = (plain - spotted).sum(axis=2)[:64, 0]
    assert np.argmax(difference) == pytest.approx(32, abs=2)
    assert difference[10] == 0.0


def test_without_variety_all_look_alike_and_with_it_they_differ():
    draws = rng()
    assert len({draw_look(draws, 0.0) for _ in range(20)}) == 1
    several = [draw_look(draws, 1.0) for _ in range(200)]
    lengths = np.array([look.length_m for look in several])
    assert lengths.std() / lengths.mean() == pytest.approx(0.07, rel=0.25)
    assert len({look.back_rgb for look in several}) > 100
    assert draw_look(rng(3), 0.7) == draw_look(rng(3), 0.7)


@given(st.integers(0, 10_000), st.floats(0.0, 1.0))
@settings(max_examples=60, deadline=None)
def test_every_variety_draws_equally_often(seed, variety):
    one, other = rng(seed), rng(seed)
    draw_look(one, variety)
    draw_look(other, 1.0)
    assert one.random() == other.random()


@pytest.mark.parametrize(
    ("name", "value"),
    [("length_m", 0.0), ("width", 2.0), ("stripes", -0.1), ("back_rgb", (0, 0, 300)), ("spots", ((0.5, 2.0),))],
)
def test_impossible_looks_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}: expected"):
        FishLook(**{name: value})


def test_impossible_variety_is_named():
    with pytest.raises(ValueError, match=r"^variety: expected"):
        draw_look(rng(), 1.1)


@pytest.mark.parametrize("species", SPECIES)
def test_every_species_is_closed_and_as_long_and_high_as_its_look(species):
    look = replace(draw_look(rng(), 0.5, species), length_m=LARGE.length_m)
    made = fish_segments(look, rng())
    for mesh in made:
        require_closed(mesh)
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)
    corners_m = np.concatenate([shape.vertices for shape in in_world(look, [0.0] * JOINT_COUNT)])
    assert np.ptp(corners_m[:, 0]) == pytest.approx(look.length_m, abs=1e-5)
    assert np.ptp(corners_m[:, 2]) == pytest.approx(2 * TAIL_REACH * look.length_m * look.height, rel=1e-4)


def test_species_look_different_and_zebrafish_as_ever():
    backs = {
        species: fish_segments(look, rng())[2].texture.rgb[:64, :6].reshape(-1, 3) for species, look in SPECIES.items()
    }
    means = {species: back.mean(axis=0) for species, back in backs.items()}
    for one, other in combinations(SPECIES, 2):
        assert np.abs(means[one] - means[other]).max() > 12, (one, other)
    # A barb's bars cross its back; a zebrafish's stripes do not.
    along = {species: back.reshape(64, 6, 3).mean(axis=(1, 2)) for species, back in backs.items()}
    assert along["barb"].std() > 3 * along["zebrafish"][14:].std()
    assert draw_look(rng(4), 0.6) == draw_look(rng(4), 0.6, "zebrafish")
