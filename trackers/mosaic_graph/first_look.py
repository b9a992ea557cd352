"""Start on the first picture: the target's axis, colours, template and contrast from its box."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.car_box import length_parts_px
from trackers.kernels.ground_camera import CENTRE_HEIGHT_M
from trackers.mosaic_graph.detector import Candidate, Cues, Detector, place
from trackers.mosaic_graph.kernels import oriented_box as ob
from trackers.mosaic_graph.registration import Registered

_SPREAD_RAD = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
_RING = (0.6, 0.85)


def look_first(detector: Detector, registered: Registered, box_xyxy: NDArray[np.float64], length_m: float) -> Candidate:
    """Train ``detector`` on the target inside a box (4,) of the first picture; return the target as a candidate."""
    camera = registered.camera
    start_m = camera.to_map(0.5 * (box_xyxy[None, :2] + box_xyxy[None, 2:]), CENTRE_HEIGHT_M)[0]
    axes_rad = _axes_rad(registered, start_m, box_xyxy)
    for axis_rad in axes_rad:
        detector.learn(registered, start_m, axis_rad, shape_rate=0.0)
    detector.learn_rest(registered, start_m)
    contrast = _contrast(registered, start_m, length_m)
    cues = Cues(detector.colours.log_ratio(registered.small_rgb), contrast)
    # The place is known from the box: a fit of it would include the car's shadow.
    trials = (axes_rad[:, None] + _SPREAD_RAD).ravel()
    found = max((detector.measure_at(registered, cues, start_m, axis) for axis in trials), key=detector.merit)
    detector.learn(registered, start_m, found.axis_rad, shape_rate=1.0)
    detector.likeness.start(found.measures)
    return found


def _axes_rad(
    registered: Registered, start_m: NDArray[np.float64], box_xyxy: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the two axes (2,) on the map along which the car may lie: an upright box has a mirrored solution."""
    across_px, down_px = length_parts_px(box_xyxy)
    map_from_picture = np.linalg.inv(place(registered.camera, start_m)[1])
    directions = map_from_picture @ np.array([[across_px, across_px], [down_px, -down_px]])
    return np.arctan2(directions[1], directions[0])


def _contrast(registered: Registered, start_m: NDArray[np.float64], length_m: float) -> NDArray[np.uint8]:
    """Return the largest difference over the colours of each pixel (H, W) from the ground around the car."""
    centre, jacobian = place(registered.camera, start_m)
    length_px = length_m * float(np.sqrt(abs(np.linalg.det(jacobian))))
    rows, columns = np.indices(registered.small_rgb.shape[:2])
    distance = np.hypot(columns - centre[0], rows - centre[1]) / length_px
    around = registered.small_rgb[(distance > _RING[0]) & (distance < _RING[1])]
    if len(around) == 0:
        return np.zeros(registered.small_rgb.shape[:2], np.uint8)
    difference = np.abs(registered.small_rgb - np.median(around, axis=0)).max(axis=2)
    return np.minimum(difference, ob.UNKNOWN - 1).astype(np.uint8)
