"""Things of one's own that people carry, from files of meshes: in the right hand, or on the back.

A thing is a further part of its carrier, in pictures and in truth. What is in the hand hangs straight down from it, its
front ahead, and moves with it; the arm swings as usual. What is on the back moves with the trunk.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.presets import CARRIED_SIDES_M, NOTHING, StereoFollow
from sim.mesh import TexturedMesh
from sim.meshes.file import mesh_of_file
from sim.meshes.person import standing_m
from sim.meshes.person_parts import PersonLook
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, skeleton
from sim.optics import invert_pose

_GRIP = 0.195
"""From the elbow to the middle of the fist, share of stature, of arms of average length."""
_BACK = 0.11
"""Height of the middle of the back above the torso's joint, share of stature, of a trunk of average length."""
_OFF_GROUND_M = 0.06
_GAP_M = 0.015
"""Between a thing in the hand and hip or leg."""
_PRESSED_M = 0.01
"""By which clothes give way to what is on the back."""
_RING_M = 0.12
"""Most between two rows of a part's vertices."""
_BESIDE = ("pelvis", "torso", "right_thigh", "right_shin", "right_foot")
_BEFORE = ("pelvis", "torso", "head", "left_thigh", "right_thigh")
"""Parts beside which a thing in the hand hangs, and before which one on the back is."""


class Carried(NamedTuple):
    """Models of what a person has in the hand and on the back: files, or ``nothing``."""

    hand: str = NOTHING
    back: str = NOTHING


def draw_carried(preset: StereoFollow, count: int, rng: np.random.Generator) -> list[Carried]:
    """Draw what each of ``count`` people carries, the target's first; see ``StereoFollow``.

    Raises:
        ValueError: for a file that is missing, whether someone carries it or not.
    """
    for model in {*preset.hand_models, *preset.back_models} - {NOTHING}:
        mesh_of_file(model, CARRIED_SIDES_M)
    drawn = rng.random((count, 2))
    made = []
    for k, (hand, back) in enumerate(drawn):
        if preset.carriers == ("others" if k == 0 else "target"):
            made.append(Carried())
        else:
            made.append(Carried(_of(preset.hand_models, hand), _of(preset.back_models, back)))
    return made


def _of(models: tuple[str, ...], share: float) -> str:
    return models[int(share * len(models))]


def without_backpack(look: PersonLook, carried: Carried) -> PersonLook:
    """Return the look of a person who has nothing else on the back than what is carried there."""
    return look if carried.back == NOTHING else replace(look, backpack_rgb=None)


@dataclass(frozen=True, eq=False)
class Load:
    """One thing that is carried.

    Attributes:
        name: ``hand`` or ``back``. mesh: its own.
        part: index of the part in ``PART_NAMES`` with which it moves.
        place_m: (3,) of its grip in the part's frame. offset_m: (3,) from there to its origin, in the person's frame
            if it hangs upright, else in the part's.
    """

    name: str
    mesh: TexturedMesh
    part: int
    place_m: NDArray[np.float64]
    offset_m: NDArray[np.float64]

    def pose(self, T_world_person: NDArray[np.float64], T_world_part: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return T_world_thing (4, 4), with the pose (4, 4) of its carrier and those (P, 4, 4) of the parts."""
        part = T_world_part[self.part]
        pose = T_world_person.copy() if self.name == "hand" else part.copy()
        pose[:3, 3] = part[:3, :3] @ self.place_m + part[:3, 3] + pose[:3, :3] @ self.offset_m
        return pose


def loads_of(look: PersonLook, carried: Carried) -> list[Load]:
    """Return what a person carries, where it stands in no part of someone who stands."""
    if carried == Carried():
        return []
    bones = skeleton(look.stature_m, look.build, look.figure)
    poses, body_m = part_poses(bones, np.eye(4), 0.0, 0.0), standing_m(look)
    made = []
    if carried.hand != NOTHING:
        mesh, part = mesh_of_file(carried.hand, CARRIED_SIDES_M), PART_NAMES.index("right_forearm")
        _, width_m, height_m = mesh.size_m.tolist()
        grip_m = np.array([0.0, 0.0, -_GRIP * bones.stature * look.figure.limbs])
        fist_m = poses[part, :3, :3] @ grip_m + poses[part, :3, 3]
        # A long thing is held farther down, so that it does not touch the ground.
        low_m = max(float(fist_m[2]) - height_m, _OFF_GROUND_M)
        beside_m = _between(body_m, _BESIDE, low_m, low_m + height_m)[:, 1]
        aside_m = max(-float(fist_m[1]), 0.5 * width_m + _GAP_M - float(beside_m.min(initial=0.0)))
        place_m = np.array([fist_m[0], -aside_m, low_m])
        made.append(Load("hand", mesh, part, grip_m, place_m - fist_m))
    if carried.back != NOTHING:
        mesh, part = mesh_of_file(carried.back, CARRIED_SIDES_M), PART_NAMES.index("torso")
        length_m, _, height_m = mesh.size_m.tolist()
        middle_m = float(poses[part, 2, 3]) + _BACK * bones.stature * look.figure.trunk
        low_m = max(middle_m - 0.5 * height_m, _OFF_GROUND_M)
        before_m = _between(body_m, _BEFORE, low_m, low_m + height_m)[:, 0]
        behind_m = float(before_m.min(initial=0.0)) + _PRESSED_M
        T_part_person = invert_pose(poses[part])
        place_m = np.array([behind_m - 0.5 * length_m, 0.0, low_m])
        made.append(Load("back", mesh, part, np.zeros(3), T_part_person[:3, :3] @ place_m + T_part_person[:3, 3]))
    return made


def _between(
    body_m: dict[str, NDArray[np.float64]], names: tuple[str, ...], low_m: float, high_m: float
) -> NDArray[np.float64]:
    """Return the vertices (V, 3) of some parts between two heights, and next to these."""
    points_m = np.concatenate([body_m[name] for name in names])
    return points_m[(points_m[:, 2] >= low_m - _RING_M) & (points_m[:, 2] <= high_m + _RING_M)]


def laden_size_m(look: PersonLook, loads: list[Load]) -> NDArray[np.float64]:
    """Return length, width and height (3,) of a person who stands: the bounds of all parts and loads."""
    poses = part_poses(skeleton(look.stature_m, look.build, look.figure), np.eye(4), 0.0, 0.0)
    points_m = [*standing_m(look).values()]
    for load in loads:
        T = load.pose(np.eye(4), poses)
        points_m.append(load.mesh.vertices_m @ T[:3, :3].T + T[:3, 3])
    return np.ptp(np.concatenate(points_m), axis=0)
