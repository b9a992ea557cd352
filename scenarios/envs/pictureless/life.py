"""All that a pictureless env knows of one episode in progress, as a plain record."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.command_link import LINK_FIELDS

LATENTS = 8
ALONG, ACROSS, SPREAD, DENSEST_ALONG, DENSEST_ACROSS, DENSEST_SHARE, PROBABILITY, LENGTH = range(LATENTS)
"""What is random about a tracker's answer, in the order of ``LIFE``'s ``latent``."""

NOBODY, ANYTHING = -1, -2
"""Instead of an index of somebody else: there is nobody whom it could follow; nobody else is known of."""

_FIELDS: list[Any] = [
    # Which of the bank's episodes, and on which frame.
    ("episode", "i8"),
    ("frame", "i8"),
    *LINK_FIELDS,
    # The carrier.
    ("place_m", "f8", (3,)),
    ("yaw_rad", "f8"),
    ("yaw_rate_rad_s", "f8"),
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
]


def life_with(*fields: Any) -> np.dtype[Any]:
    """Return the record with more fields, of a carrier's own.

    They come first: Numba takes a record that begins like another for a kind of it, and a kernel compiled for either
    would serve both.
    """
    return np.dtype([*fields, *_FIELDS], align=True)


LIFE = life_with()
