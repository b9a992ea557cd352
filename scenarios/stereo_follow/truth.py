"""Truth before a stereo camera, in addition to the fields of every scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from scenarios.person_keypoints import PERSON
from scenarios.truth import Keypoints, Truth, keypoints_field, truth_field
from trackers.types import CameraRegisters

LightEvent = Literal["lamp on", "lamp off", "back light", "doorway", "shade"]


@dataclass(frozen=True, slots=True)
class StereoTruth(Truth):
    """Truth of one frame of a stereo camera. Maps and depth of ``Truth`` are those of the left camera.

    Attributes:
        T_world_right: (4, 4), true pose of the right camera.
        right_instance_map: (H, W) int32, right_depth_m: (H, W) float32, as those of the left camera.
        illuminance_lx: (N,) on the side of each object that faces the camera.
        place: of the target, e.g. ``corridor``, ``hall``, ``door``, ``yard``.
        light_event: a new change of the light on the target or in the picture, for as long as it counts as new; None
            without one.
        registers: the camera's settings as it reports them.
    """

    T_world_right: NDArray[np.float64] = truth_field("m", 4, 4)
    right_instance_map: NDArray[np.int32] = truth_field("id", "H", "W", coding="as instance_map")
    right_depth_m: NDArray[np.float32] = truth_field("m", "H", "W", coding="as depth_m")
    illuminance_lx: NDArray[np.float64] = truth_field("lx", "N")
    place: str = truth_field("word")
    light_event: LightEvent | None = truth_field("word", coding="None while no change of light is new")
    registers: CameraRegisters = truth_field("1")


@dataclass(frozen=True, slots=True)
class PeopleTruth(StereoTruth):
    """Truth of one frame of a person followed among N people.

    Illuminance is measured on an upright surface at each person's chest that faces the camera.

    Attributes:
        occluder: (N,) index of the person who hides most of each person, -1 for none; with ``truth="target"`` -1 for
            all but the target.
        near_person: whether a person other than the target is within 1.5 m of the camera and in its picture.
        keypoints_m: (N, 17, 3) joints and face of each person, in the order of COCO.
    """

    keypoints: ClassVar[Mapping[str, Keypoints]] = {"person": PERSON}

    occluder: NDArray[np.int64] = truth_field("1", "N", coding="index of an object, -1 for none", left_out=True)
    near_person: bool = truth_field("1")
    keypoints_m: NDArray[np.float64] = keypoints_field(PERSON)
