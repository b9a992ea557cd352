"""Named points of a person: joints and face, in the frames of the parts that carry them."""

from __future__ import annotations

import numpy as np

from sim.jointed_labels import PartPoints
from sim.motion.skeleton import PART_NAMES, Skeleton

_FACE = ("nose", "left eye", "right eye", "left ear", "right ear")
_JOINTS = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
PERSON_POINTS = (*_FACE, *(f"{side} {joint}" for joint in _JOINTS for side in ("left", "right")))
"""The 17 points of COCO, in its order; left and right are the person's own."""

_PART_OF_JOINT = dict(zip(_JOINTS, ("upper_arm", "forearm", "forearm", "thigh", "shin", "foot"), strict=True))
_HEAD = 0.155
"""Height of the crown above the joint of the head, share of stature, of the head that the following are of."""
_FACE_PLACES = np.array(
    [
        (0.0815, 0.0, 0.0590),
        (0.0590, 0.0180, 0.0835),
        (0.0590, -0.0180, 0.0835),
        (0.0110, 0.0485, 0.0755),
        (0.0110, -0.0485, 0.0755),
    ]
)
"""Tip of the nose, pupils (63 mm apart in an adult), ears, from the joint of the head: as the mesh has them."""


def person_points(bones: Skeleton) -> PartPoints:
    """Return ``PERSON_POINTS`` of a person: joints lie where parts hang, the wrist at the end of the forearm."""
    crown_m = bones.stature - (bones.ankle + bones.shin + bones.thigh + bones.pelvis + bones.neck)
    places_m = np.zeros((len(PERSON_POINTS), 3))
    places_m[: len(_FACE)] = crown_m / _HEAD * _FACE_PLACES
    parts = [PART_NAMES.index("head")] * len(_FACE)
    for name in PERSON_POINTS[len(_FACE) :]:
        side, joint = name.split()
        if joint == "wrist":
            places_m[len(parts), 2] = -bones.forearm
        parts.append(PART_NAMES.index(f"{side}_{_PART_OF_JOINT[joint]}"))
    return PartPoints(np.array(parts), places_m)
