"""Shapes and clothes of people: closed, smooth, of their size, in their colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.mesh import TexturedMesh
from sim.meshes.person import PATCHES, SIZE_TEXELS, person_parts, person_size_m
from sim.meshes.person_parts import PersonLook
from sim.meshes.population import draw_person
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, Figure, skeleton
from tests.sim.meshes.mesh_checks import parts, require_closed, welded

PLAIN = PersonLook()
DRESSED = PersonLook(
    stature_m=1.9, build=1.2, hair_style="long", cap_rgb=(20, 60, 40), legwear="shorts", backpack_rgb=(150, 80, 30)
)
SLIGHT = PersonLook(stature_m=1.37, build=0.8, hair_style="long")
STOUT = PersonLook(
    stature_m=1.6,
    build=1.15,
    figure=Figure(shoulders=0.9, hips=1.2, waist=1.45, belly=0.5, bust=0.5, limbs=0.93, head=1.05),
    hair_style="bun",
    cap_rgb=(60, 60, 90),
    headwear="hat",
    top_length="thigh",
    inner_rgb=(210, 205, 200),
    legwear="skirt",
    stockings_rgb=(40, 36, 40),
    bag_rgb=(110, 70, 50),
)
CHILD = PersonLook(
    stature_m=1.1,
    build=0.9,
    figure=Figure(limbs=0.93, head=1.42),
    hair_style="ponytail",
    top_pattern="print",
    legwear="skirt",
    backpack_rgb=(150, 80, 30),
)
VEILED = PersonLook(figure=Figure(waist=0.8), cap_rgb=(90, 40, 60), headwear="scarf")
looks = st.builds(
    PersonLook,
    stature_m=st.floats(1.37, 2.07),
    build=st.floats(0.8, 1.2),
    hair_style=st.sampled_from(["short", "long"]),
    cap_rgb=st.sampled_from([None, (20, 60, 40)]),
    legwear=st.sampled_from(["trousers", "shorts"]),
    backpack_rgb=st.sampled_from([None, (150, 80, 30)]),
)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def mean_rgb(mesh: TexturedMesh, patch: str) -> np.ndarray:
    box = PATCHES[patch]
    rows = slice(round(box.top * SIZE_TEXELS[0]), round(box.bottom * SIZE_TEXELS[0]))
    columns = slice(round(box.left * SIZE_TEXELS[1]), round(box.right * SIZE_TEXELS[1]))
    return mesh.texture.rgb[rows, columns].reshape(-1, 3).mean(axis=0)


@pytest.mark.parametrize("look", [PLAIN, SLIGHT, DRESSED, STOUT, CHILD, VEILED])
def test_every_part_is_closed_smooth_and_turned_outwards(look):
    made = person_parts(look, rng())
    assert tuple(made) == PART_NAMES
    assert sum(len(mesh.faces) for mesh in made.values()) <= 2_500
    for mesh in made.values():
        require_closed(mesh)
        assert (mesh.vertices_m.dtype, mesh.normals.dtype, mesh.uv.dtype, mesh.faces.dtype) == (np.float32,) * 3 + (
            np.int32,
        )
        assert mesh.uv.min() >= 0.0
        assert mesh.uv.max() <= 1.0
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)
        a, b, c = np.moveaxis(mesh.vertices_m[mesh.faces].astype(float), 1, 0)
        area = np.cross(b - a, c - a)
        assert np.linalg.norm(area, axis=1).min() > 1e-7
        # Smooth normals lean away from those of faces, at the rims of hollow hems by more than a right angle.
        cosine = (mesh.normals[mesh.faces] * area[:, None]).sum(axis=2) / np.linalg.norm(area, axis=1)[:, None]
        assert cosine.min() > -0.35
        assert np.median(cosine) > 0.8


@given(looks)
@settings(max_examples=5, deadline=None)
def test_a_person_is_of_a_persons_size(look):
    length_m, width_m, height_m = person_size_m(look)
    assert height_m == pytest.approx(look.stature_m, abs=0.012 * look.stature_m)
    assert 0.24 < width_m / look.stature_m / look.build < 0.34
    assert length_m < 0.28 * look.stature_m
    poses = part_poses(skeleton(look.stature_m, look.build), np.eye(4), 0.0, 0.0)
    points = [
        mesh.vertices_m @ T[:3, :3].T + T[:3, 3]
        for mesh, T in zip(person_parts(look, rng()).values(), poses, strict=True)
    ]
    assert np.concatenate(points)[:, 2].min() == pytest.approx(0.0, abs=0.001)
    assert np.ptp(np.concatenate(points), axis=0) == pytest.approx([length_m, width_m, height_m], abs=1e-5)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.5]))
@settings(max_examples=12, deadline=None)
def test_whoever_is_drawn_stands_on_the_ground_and_is_as_tall_as_told(seed, children):
    look = draw_person(rng(seed), children=children)
    height_m = person_size_m(look)[2]
    # Hair, hats and their brims stand off.
    assert -0.008 < height_m / look.stature_m - 1.0 < 0.03
    poses = part_poses(skeleton(look.stature_m, look.build, look.figure), np.eye(4), 1.0, 1.2)
    lowest_m = [
        (mesh.vertices_m @ T[:3, :3].T + T[:3, 3])[:, 2].min()
        for mesh, T in zip(person_parts(look, rng()).values(), poses, strict=True)
    ]
    assert min(lowest_m) == pytest.approx(0.0, abs=0.006 * look.stature_m)


def test_figures_change_what_they_name():
    made = {
        name: person_parts(replace(PLAIN, figure=Figure(**changed)), rng())
        for name, changed in (
            ("plain", {}),
            ("waist", {"waist": 1.3}),
            ("hips", {"hips": 1.2}),
            ("head", {"head": 1.4}),
        )
    }

    def breadth_m(name, part, z):
        points_m = made[name][part].vertices_m
        return np.ptp(points_m[np.abs(points_m[:, 2] - z * PLAIN.stature_m) < 0.03, 1])

    assert breadth_m("waist", "torso", 0.07) == pytest.approx(1.3 * breadth_m("plain", "torso", 0.07), rel=0.03)
    assert breadth_m("hips", "pelvis", -0.012) == pytest.approx(1.2 * breadth_m("plain", "pelvis", -0.012), rel=0.03)
    assert np.ptp(made["head"]["head"].vertices_m[:, 1]) > 1.3 * np.ptp(made["plain"]["head"].vertices_m[:, 1])
    assert Figure(limbs=1.05).trunk < 1.0 < Figure(limbs=0.95).trunk
    with pytest.raises(ValueError, match=r"figure.waist: expected a number within \[0.75, 1.5\], got 2"):
        PersonLook(figure=Figure(waist=2.0))


@pytest.mark.parametrize("look", [PLAIN, DRESSED, STOUT])
def test_parts_reach_over_their_joints(look):
    """The joint lies inside of the part on either side of it, so that nothing gapes however it bends."""
    made, bones = person_parts(look, rng()), skeleton(look.stature_m, look.build, look.figure)
    joints = [
        ("pelvis", (0, 0, bones.pelvis), "torso"),
        ("torso", (0, 0, bones.neck), "head"),
        ("torso", (0, bones.half_shoulders - 0.01, bones.shoulder - 0.01), None),
        ("left_upper_arm", (0, 0, -bones.upper_arm), "left_forearm"),
        ("pelvis", (0, bones.half_hips, 0), "left_thigh"),
        ("left_thigh", (0, 0, -bones.thigh), "left_shin"),
    ]
    for upper, place_m, lower in joints:
        assert any(part.contains([place_m])[0] for part in parts(made[upper])), (upper, lower)
        if lower is not None:
            assert any(part.contains([(0.0, 0.0, 0.0)])[0] for part in parts(made[lower])), (upper, lower)
    # The hem of a trouser leg hangs over the shoe, and a bare leg reaches into it.
    assert made["left_shin"].vertices_m[:, 2].min() + bones.shin < made["left_foot"].vertices_m[:, 2].max() - 0.005


def test_a_chest_is_wider_than_a_waist_and_a_nose_points_ahead():
    made = person_parts(PLAIN, rng())
    torso = made["torso"].vertices_m / PLAIN.stature_m
    chest, waist = (np.ptp(torso[np.abs(torso[:, 2] - z) < 0.025, 1]) for z in (0.18, 0.06))
    assert chest > 1.2 * waist
    head = made["head"].vertices_m
    tip = head[head[:, 0].argmax()]
    assert abs(tip[1]) < 1e-6
    foot = welded(made["left_foot"]).vertices
    assert foot[:, 0].max() > 2.5 * -foot[:, 0].min()


def test_people_wear_what_they_are_told_to():
    look = replace(PLAIN, top_rgb=(180, 40, 40), legwear_rgb=(40, 50, 120), shoes_rgb=(60, 60, 60))
    torso = person_parts(look, rng())["torso"]
    np.testing.assert_allclose(mean_rgb(torso, "torso"), look.top_rgb, rtol=0.15)
    np.testing.assert_allclose(mean_rgb(torso, "thigh"), look.legwear_rgb, rtol=0.15)
    np.testing.assert_allclose(mean_rgb(torso, "forearm"), look.top_rgb, rtol=0.15)
    short = person_parts(replace(look, sleeves="short", legwear="shorts"), rng())["torso"]
    np.testing.assert_allclose(mean_rgb(short, "forearm"), look.skin_rgb, rtol=0.1)
    np.testing.assert_allclose(mean_rgb(short, "shin"), look.skin_rgb, rtol=0.1)
    striped = person_parts(replace(look, top_pattern="stripes"), rng())["torso"]
    assert mean_rgb(striped, "torso")[0] < 0.85 * mean_rgb(torso, "torso")[0]


def test_cloth_has_grain_for_matching():
    rgb = person_parts(PLAIN, rng())["torso"].texture.rgb.astype(float)
    box = PATCHES["torso"]
    cloth = rgb[60:150, round(box.left * SIZE_TEXELS[1]) : round(box.right * SIZE_TEXELS[1])].mean(axis=2)
    assert 0.015 < np.abs(np.diff(cloth, axis=1)).mean() / cloth.mean() < 0.08


def test_people_are_the_same_for_the_same_generator_and_share_shapes():
    one, same, other = (person_parts(PLAIN, rng(seed)) for seed in (1, 1, 2))
    for name in PART_NAMES:
        assert one[name].vertices_m is other[name].vertices_m
        assert one[name].texture is one["head"].texture
    np.testing.assert_array_equal(one["head"].texture.rgb, same["head"].texture.rgb)
    assert not np.array_equal(one["head"].texture.rgb, other["head"].texture.rgb)
    assert one["head"].texture.smooth


def test_impossible_looks_are_named():
    with pytest.raises(ValueError, match=r"stature_m: expected a length within"):
        PersonLook(stature_m=0.9)
    with pytest.raises(ValueError, match=r"top_pattern: expected one of \('plain', 'stripes', 'check', .*, got dots"):
        PersonLook(top_pattern="dots")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"skin_rgb: expected three numbers from 0 to 255, got"):
        PersonLook(skin_rgb=(300, 0, 0))
