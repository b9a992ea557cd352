"""All that a pictureless env knows of one episode in progress, as a plain record."""

from __future__ import annotations

import numpy as np

LATENTS = 8
ALONG, ACROSS, SPREAD, DENSEST_ALONG, DENSEST_ACROSS, DENSEST_SHARE, PROBABILITY, LENGTH = range(LATENTS)
"""What is random about a tracker's answer, in the order of ``LIFE``'s ``latent``."""

NOBODY, ANYTHING = -1, -2
"""Instead of an index of somebody else: there is nobody whom it could follow; nobody else is known of."""

LIFE = np.dtype(
    [
        # Which of the bank's episodes, on which frame, and how many steps ago it was begun.
        ("episode", "i8"),
        ("frame", "i8"),
        ("steps", "i8"),
        # The carrier; ``speed_mps`` is a robot's, the other velocities a helicopter's.
        ("place_m", "f8", (3,)),
        ("yaw_rad", "f8"),
        ("velocity_mps", "f8", (3,)),
        ("speed_mps", "f8"),
        ("yaw_rate_rad_s", "f8"),
        ("shake_rad", "f8", (2,)),
        # What its instruments make of that.
        ("position_bias_m", "f8", (3,)),
        ("attitude_bias_rad", "f8", (3,)),
        ("odometry", "f8", (3,)),
        ("odometry_scales", "f8", (2,)),
        # The latest command after limits, and the one obeyed: forward, right, climb, yaw rate.
        ("command", "f8", (4,)),
        ("obeyed", "f8", (4,)),
        # R_world_camera and the camera's place, true and as measured.
        ("R", "f8", (3, 3)),
        ("camera_m", "f8", (3,)),
        ("R_measured", "f8", (3, 3)),
        ("camera_measured_m", "f8", (3,)),
        # What is so of the target.
        ("target_m", "f8", (2,)),
        ("target_rad", "f8"),
        ("target_px", "f8", (2,)),
        ("length_px", "f8"),
        ("visible", "f8"),
        ("centring", "f8"),
        ("in_view", "f8"),
        ("frames_out", "i8"),
        # What the tracker is up to, see ``error_kernel``.
        ("condition", "i8"),
        ("condition_frames", "i8"),
        ("mode", "i8"),
        ("unsure_frames", "i8"),
        # Whom it follows, or would, if it takes somebody else for its target, and where he is from there.
        ("other", "i8"),
        ("other_offset_m", "f8", (2,)),
        ("axis_rad", "f8"),
        ("latent", "f8", (LATENTS,)),
        # What it says.
        ("known", "f8"),
        ("estimate_px", "f8", (2,)),
        ("depth_m", "f8"),
        ("probability", "f8"),
        ("length_share", "f8"),
        ("spread_m", "f8"),
        ("densest_offset_m", "f8", (2,)),
        ("densest_share", "f8"),
    ],
    align=True,
)
