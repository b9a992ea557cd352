"""The pan-tilt-zoom head beside the overview camera, which carries the steered thermal camera."""

from __future__ import annotations

import numpy as np

from scenarios.harbour.layout import AIM_M, CAMERA_M
from scenarios.pan_tilt_zoom import Mount
from trackers.types import CameraModel, Carrier, CommandAxis

HEAD = Carrier(
    "harbour-head",
    (CommandAxis("pan_rad_s", 1.0, 4.0), CommandAxis("tilt_rad_s", 0.6, 3.0), CommandAxis("zoom_per_s", 0.7, 3.0)),
    "around",
)
"""Limits are those of a surveillance head with a motor zoom."""
LENS = CameraModel.from_field_of_view(384, 288, float(np.deg2rad(5.0)), band="thermal")
"""Of its camera at zoom 1: at 100 m it sees 9 m, and a person 75 pixels tall."""
MOUNT = Mount(
    HEAD,
    LENS,
    place_m=(CAMERA_M[0], CAMERA_M[1] - 0.8, CAMERA_M[2] - 0.5),
    aim_m=AIM_M,
    ahead=(1.0, 0.0),
    left=(0.0, 1.0),
    widest_pan_rad=0.9,
    tilt_rad=(-0.9, 0.1),
    zoom=(0.5, 3.0),
)
