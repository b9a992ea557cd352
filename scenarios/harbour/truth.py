"""Truth of the harbour, in addition to the fields of every scenario, and its map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.person_keypoints import PERSON
from scenarios.truth import Keypoints, Truth, keypoints_field, truth_field
from sim.thermal.radiance import apparent_temperature_k

_RING_PX = 3
"""Width of the ring of background around an object."""


@dataclass(frozen=True, slots=True)
class HarbourTruth(Truth):
    """Truth of one frame. Each appearance of a person, car or boat is an object of its own.

    Attributes:
        temperature_contrast_k: (N,) mean apparent temperature of the pixels that show the object, minus that of the
            ring of background around them, before the sensor; NaN where it is not seen.
        contrast_to_noise: (N,) of a matched filter: root of the sum of squares of its pixels' contrasts, over the
            temporal noise of a pixel; NaN where it is not seen.
        watched: (N,) whether its centre is inside the watched volume.
        keypoints_m: (N, 17, 3) joints and face of each person, in the order of COCO; NaN for cars and boats.
        tide_m: level of the sea over its mean. wave_height_m: significant height of the waves.
        agc_gain: grey levels per kelvin of the gain control's curve; drawn harbours show small differences at more.
        agc_step: whether the gain control jumped or the shutter corrected the pattern since the last frame.
    """

    keypoints: ClassVar[Mapping[str, Keypoints]] = {"person": PERSON}

    temperature_contrast_k: NDArray[np.float64] = truth_field("K", "N", coding="NaN where it is not seen")
    contrast_to_noise: NDArray[np.float64] = truth_field("1", "N", coding="NaN where it is not seen")
    watched: NDArray[np.bool_] = truth_field("1", "N", coding="its centre is inside the watched volume")
    tide_m: float = truth_field("m")
    wave_height_m: float = truth_field("m")
    agc_gain: float = truth_field("1", coding="grey levels per kelvin of the gain control's curve")
    agc_step: bool = truth_field("1", coding="grey levels jumped, or the shutter corrected the pattern")
    keypoints_m: NDArray[np.float64] = keypoints_field(PERSON)


@dataclass(frozen=True, slots=True)
class HarbourMap:
    """What is where.

    Attributes:
        volume_m: (3,) sides of the watched volume along the line of sight, across it, and upright.
        volume_centre_m: (3,).
        volume_axes: (2, 2) level unit vectors along the first two.
        clutter: instance id -> ``sea``, ``moored``, ``rope``, ``bird``, ``parked``, ``land`` or ``building``.
        land_m: (n, 2) outline of the land. wall_m: (k, 2) the quay's edge.
    """

    volume_m: NDArray[np.float64]
    volume_centre_m: NDArray[np.float64]
    volume_axes: NDArray[np.float64]
    clutter: Mapping[int, str]
    land_m: NDArray[np.float64]
    wall_m: NDArray[np.float64]


def contrasts(
    radiance: NDArray[np.float32],
    instance_map: NDArray[np.int32],
    objects: NDArray[np.int64],
    box_xyxy: NDArray[np.float64],
    netd_k: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return contrasts (N,) in kelvin, and over noise (N,); NaN for objects without a pixel.

    The ring leaves out pixels of all objects and crews.

    Args:
        radiance: (H, W) in W/(m² sr).
        instance_map: (H, W) with the ids ``objects`` (N,), the first of which is greater than all that are no object's
            or a crew's.
        box_xyxy: (N, 4), NaN for the absent.
    """
    contrast_k, to_noise = np.full(len(objects), np.nan), np.full(len(objects), np.nan)
    height, width = instance_map.shape
    kernel = np.ones((2 * _RING_PX + 1, 2 * _RING_PX + 1), np.uint8)
    for k in np.flatnonzero(np.isfinite(box_xyxy).all(axis=1)):
        low = np.maximum(np.floor(box_xyxy[k, :2]) - _RING_PX - 1, 0).astype(int)
        high = np.minimum(np.ceil(box_xyxy[k, 2:]) + _RING_PX + 1, (width, height)).astype(int)
        if (high <= low).any():
            continue
        window = slice(low[1], high[1]), slice(low[0], high[0])
        ids = instance_map[window]
        own = ids == objects[k]
        around = cv2.dilate(own.astype(np.uint8), kernel).astype(bool) & (ids < objects[0])
        if not own.any() or not around.any():
            continue
        kelvin = apparent_temperature_k(radiance[window])
        above = kelvin[own] - kelvin[around].mean()
        contrast_k[k] = above.mean()
        to_noise[k] = np.sqrt((above**2).sum()) / netd_k
    return contrast_k, to_noise
