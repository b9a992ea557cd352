"""Named points of people, against the mesh that is drawn and against each other."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sim.jointed_labels import places_of
from sim.meshes.person import person_parts
from sim.meshes.person_parts import PersonLook
from sim.motion.gait import part_poses
from sim.motion.keypoints import PERSON_POINTS, person_points
from sim.motion.skeleton import AVERAGE, PART_NAMES, Figure, skeleton
from sim.pose import pose_on_ground

SIZES = [(1.45, 0.8, AVERAGE), (1.74, 1.0, AVERAGE), (2.0, 1.2, AVERAGE), (1.1, 1.0, Figure(limbs=0.9, head=1.4))]


def placed(stature_m: float, build: float, phase_rad: float = 0.0, speed_mps: float = 0.0) -> dict[str, np.ndarray]:
    bones = skeleton(stature_m, build)
    poses = part_poses(bones, pose_on_ground(3.0, -1.0, 0.7), phase_rad, speed_mps)
    return dict(zip(PERSON_POINTS, places_of(person_points(bones), poses), strict=True))


@pytest.mark.parametrize(("stature_m", "build", "figure"), SIZES)
def test_the_face_lies_on_the_mesh_and_joints_lie_in_it(stature_m: float, build: float, figure: Figure) -> None:
    look = PersonLook(stature_m=stature_m, build=build, figure=figure)
    meshes = dict(zip(PART_NAMES, person_parts(look, np.random.default_rng(0)).values(), strict=True))
    points = person_points(skeleton(stature_m, build, figure))
    for name, part, place_m in zip(PERSON_POINTS, points.part, points.place_m, strict=True):
        mesh = meshes[PART_NAMES[part]]
        solid = trimesh.Trimesh(mesh.vertices_m, mesh.faces, process=False)
        _, away_m, _ = trimesh.proximity.closest_point_naive(solid, place_m[None])
        if name in PERSON_POINTS[:5]:
            assert away_m[0] < 0.008 * stature_m, name
        else:
            assert solid.contains(place_m[None])[0], name


@pytest.mark.parametrize("phase_rad", [0.0, 1.0, 4.0])
def test_limbs_keep_their_lengths_and_left_is_left(phase_rad: float) -> None:
    bones, points = skeleton(1.8, 1.1), placed(1.8, 1.1, phase_rad, 1.3)
    for side in ("left", "right"):
        for a, b, length_m in (
            ("shoulder", "elbow", bones.upper_arm),
            ("elbow", "wrist", bones.forearm),
            ("hip", "knee", bones.thigh),
            ("knee", "ankle", bones.shin),
        ):
            assert np.linalg.norm(points[f"{side} {a}"] - points[f"{side} {b}"]) == pytest.approx(length_m, rel=1e-3)
    to_left = np.array([-np.sin(0.7), np.cos(0.7), 0.0])
    for name in ("eye", "ear", "shoulder", "hip"):
        assert (points[f"left {name}"] - points[f"right {name}"]) @ to_left > 0.05
    assert points["nose"][2] < points["left eye"][2] < 1.8


def test_points_stand_in_the_order_of_coco() -> None:
    assert len(PERSON_POINTS) == 17
    assert [PERSON_POINTS[k] for k in (0, 1, 4, 5, 9, 12, 16)] == [
        "nose", "left eye", "right ear", "left shoulder", "left wrist", "right hip", "right ankle",
    ]  # fmt: skip
