"""Blobs of a foreground mask as upright objects on a quay or the water before it, with their sizes in metres."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.registry import tunable
from trackers.site.quay import stood_on
from trackers.site.survey import Site


@dataclass(frozen=True)
class BlobParameters:
    """Parameters of the blobs.

    Attributes:
        opening_px, closing_px: sides of the squares of both morphological operations, 1 for none.
        least_area_px: of a blob.
        greatest_share: of the picture that may be foreground; beyond it the camera's gain has changed.
    """

    opening_px: int = tunable(1, 1, 3)
    closing_px: int = tunable(5, 1, 9)
    least_area_px: int = tunable(6, 2, 40)
    greatest_share: float = tunable(0.25, 0.05, 0.8)


@dataclass(frozen=True, eq=False)
class Blob:
    """An object on the quay or the water.

    Attributes:
        place_m: (3,) middle of its base, half its width behind the foot of the blob.
        covariance_m2: (2, 2) of the place: a pixel in each direction, and the object's own width.
        box_xyxy: (4,) in the picture.
        size_m: (3,) its width, twice, since its depth is not seen, and its height.
        strength: root of the sum of squared contrasts to noise over its pixels, >= 0.
    """

    place_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    size_m: NDArray[np.float64]
    strength: float


def blobs_of(
    foreground: NDArray[np.uint8],
    contrast: NDArray[np.float32],
    site: Site,
    parameters: BlobParameters,
) -> list[Blob]:
    """Return the objects of a mask whose feet stand inside the watched volume, seen from above.

    Args:
        foreground: (H, W), not 0 where something is.
        contrast: (H, W) magnitude of the difference from the background, in standard deviations of its noise.
    """
    p = parameters
    mask = (foreground != 0).astype(np.uint8)
    if float(np.count_nonzero(mask)) > p.greatest_share * mask.size:
        return []
    for operation, side_px in ((cv2.MORPH_OPEN, p.opening_px), (cv2.MORPH_CLOSE, p.closing_px)):
        if side_px > 1:
            mask = cv2.morphologyEx(mask, operation, np.ones((side_px, side_px), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    power = np.bincount(labels.ravel(), weights=np.square(contrast, dtype=np.float64).ravel(), minlength=count)
    found = []
    for label in range(1, count):
        if stats[label, cv2.CC_STAT_AREA] >= p.least_area_px:
            blob = _standing(stats[label, : cv2.CC_STAT_AREA].astype(float), float(np.sqrt(power[label])), site)
            if blob is not None:
                found.append(blob)
    return found


def _standing(box_xywh: NDArray[np.float64], strength: float, site: Site) -> Blob | None:
    """Return a box (4,) in the picture as an object; None if it stands outside the watched volume."""
    x, y, width_px, height_px = box_xywh
    foot = np.array([x + 0.5 * width_px, y + height_px])
    feet_m = stood_on(site.survey, site.view, foot + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    if not (np.isfinite(feet_m).all() and site.volume.contains(feet_m[:1])[0]):
        return None
    depth_m = float(site.view.project(feet_m[:1])[1][0])
    width_m, height_m = np.array([width_px, height_px]) * depth_m / site.view.camera.focal_px
    steps_m = (feet_m[1:, :2] - feet_m[0, :2]).T
    covariance_m2 = steps_m @ steps_m.T + (0.25 * width_m) ** 2 * np.eye(2)
    box_xyxy = np.array([x, y, x + width_px, y + height_px])
    size_m = np.array([width_m, width_m, height_m])
    ahead = feet_m[0] - site.view.place_m
    ahead[2] = 0.0
    place_m = feet_m[0] + 0.5 * width_m * ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    return Blob(place_m, covariance_m2, box_xyxy, size_m, strength)
