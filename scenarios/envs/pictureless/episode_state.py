"""The state of one episode in a pictureless env, as a plain record."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenarios.command_link import LINK_FIELDS

LATENTS = 8
ALONG, ACROSS, SPREAD, DENSEST_ALONG, DENSEST_ACROSS, DENSEST_SHARE, PROBABILITY, LENGTH = range(LATENTS)
"""The random quantities of a tracker's answer, in the order of ``EPISODE_STATE``'s ``latent``."""

NO_OTHER, OTHER_UNKNOWN = -1, -2
"""Instead of another object's index: no other object is in sight; the scene does not model other objects."""

_FIELDS: list[Any] = [
    # Index of the bank's episode, and its frame.
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
    # The target's truth.
    ("target_m", "f8", (2,)),
    ("target_rad", "f8"),
    ("target_px", "f8", (2,)),
    ("length_px", "f8"),
    ("visible", "f8"),
    ("centring", "f8"),
    ("in_view", "f8"),
    ("frames_out", "i8"),
    # The tracker's mode, see ``error_kernel``.
    ("condition", "i8"),
    ("condition_frames", "i8"),
    ("mode", "i8"),
    ("unsure_frames", "i8"),
    # The object that the tracker confuses, or would confuse, with its target: index, and place relative to the target.
    ("other", "i8"),
    ("other_offset_m", "f8", (2,)),
    ("axis_rad", "f8"),
    ("latent", "f8", (LATENTS,)),
    # The tracker's answer.
    ("known", "f8"),
    ("estimate_px", "f8", (2,)),
    ("depth_m", "f8"),
    ("probability", "f8"),
    ("length_share", "f8"),
    ("spread_m", "f8"),
    ("densest_offset_m", "f8", (2,)),
    ("densest_share", "f8"),
]


def state_dtype(*fields: Any) -> np.dtype[Any]:
    """Return the record's dtype with a carrier's own ``fields``.

    They come first: Numba would treat a record that begins like another as a subtype of it, and would use a kernel
    compiled for one on the other.
    """
    return np.dtype([*fields, *_FIELDS], align=True)


EPISODE_STATE = state_dtype()
