"""The pan-tilt-zoom head beside the tank, which carries the steered camera."""

from __future__ import annotations

import numpy as np

from scenarios.pan_tilt_zoom import Mount
from trackers.types import CameraModel, Carrier, CommandAxis

HEAD = Carrier(
    "tank-head",
    (CommandAxis("pan_rad_s", 2.0, 12.0), CommandAxis("tilt_rad_s", 2.0, 12.0), CommandAxis("zoom_per_s", 1.0, 5.0)),
    "around",
)
"""Limits are those of a small servo head with a motor zoom."""
LENS = CameraModel.from_field_of_view(320, 240, float(np.deg2rad(15.0)))
"""Of its camera at zoom 1: it then sees two fifths of the tank's length."""
MOUNT = Mount(
    HEAD,
    LENS,
    place_m=(0.0, -0.5, 0.85),
    aim_m=(0.0, 0.0, 0.0),
    ahead=(0.0, 1.0),
    left=(-1.0, 0.0),
    widest_pan_rad=1.3,
    tilt_rad=(-1.4, -0.5),
    zoom=(1.0, 3.0),
)
