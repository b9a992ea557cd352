"""What ``info`` holds: truth, for scoring. The same keys on every step; plain numbers and arrays of fixed shape."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

import numpy as np

from scenarios.envs.reward import TERMS
from scenarios.in_view import centring, is_in_view, length_px
from scenarios.scenario import Frame
from scenarios.truth import VisibilityState
from trackers.types import CameraCommand, Estimate

_STATES = get_args(VisibilityState)
NO_REWARD = dict.fromkeys(TERMS, 0.0)
INFO: dict[str, tuple[str, tuple[int, ...], str]] = {
    "episode_seed": ("int64", (), "seed of the episode in the catalogue"),
    "frame": ("int64", (), "index of the frame, from 0"),
    "time_s": ("float64", (), "seconds since frame 0"),
    "in_view": ("bool", (), "target's centre in the picture, hidden or not, and its box at least 12 pixels long"),
    "state": ("int64", (), f"index of the target's state in {', '.join(_STATES)}"),
    "centring": ("float64", (), "1 with the target in the middle of the picture, 0 on its border and outside"),
    "length_px": ("float64", (), "longer side of the target's true box in pixels; 0 behind the camera"),
    "visible_fraction": ("float64", (), "share in [0, 1] of the target that is visible"),
    "frames_since_exit": ("int64", (), "0 on the first frame with the target outside; -1 while it is not"),
    "position_px": ("float64", (2,), "target's true centre in pixels, also outside the picture; NaN behind the camera"),
    "box_xyxy": ("float64", (4,), "target's true box in pixels, also outside the picture; NaN behind the camera"),
    "place_m": ("float64", (3,), "target's true place in the world, in metres"),
    "T_world_camera": ("float64", (4, 4), "camera's true pose, translation in metres"),
    "error_px": ("float64", (), "distance in pixels of the tracker's estimate from the true centre; NaN without one"),
    "command": ("float64", (4,), "command obeyed: forward, right and climb in m/s, yaw rate in rad/s"),
    **{f"reward_{term}": ("float64", (), "weighted term of the step's reward; 0 after a reset") for term in TERMS},
}
"""Key -> dtype and shape of its value, and what that is."""


def truth_info(
    frame: Frame,
    estimate: Estimate,
    obeyed: CameraCommand,
    terms: Mapping[str, float],
    episode_seed: int,
) -> dict[str, Any]:
    """Return the info of one step, see ``INFO``; ``terms`` are the reward's, weights included."""
    truth, target = frame.truth, frame.truth.target
    return {
        "episode_seed": episode_seed,
        "frame": truth.frame,
        "time_s": float(truth.time_s),
        "in_view": is_in_view(truth, frame.camera),
        "state": _STATES.index(truth.state),
        "centring": centring(truth, frame.camera),
        "length_px": length_px(truth),
        "visible_fraction": float(truth.visible_fraction[target]),
        "frames_since_exit": truth.frames_since_exit,
        "position_px": truth.position_px[target].copy(),
        "box_xyxy": truth.box_xyxy[target].copy(),
        "place_m": truth.T_world_object[target, :3, 3].copy(),
        "T_world_camera": truth.T_world_camera.copy(),
        "error_px": float(np.linalg.norm(np.asarray(estimate.position_px) - truth.position_px[target])),
        "command": np.array([obeyed.forward_mps, obeyed.right_mps, obeyed.climb_mps, obeyed.yaw_rate_rad_s]),
        **{f"reward_{term}": terms[term] for term in TERMS},
    }
