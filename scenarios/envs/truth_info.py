"""What ``info`` says of an instant: truth, for scoring. The same keys on every step; plain numbers and fixed arrays."""

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
INFO: dict[str, tuple[str, tuple[int, ...]]] = {
    "episode_seed": ("int64", ()),
    "frame": ("int64", ()),
    "time_s": ("float64", ()),
    "in_view": ("bool", ()),
    "state": ("int64", ()),
    "centring": ("float64", ()),
    "length_px": ("float64", ()),
    "visible_fraction": ("float64", ()),
    "frames_since_exit": ("int64", ()),
    "position_px": ("float64", (2,)),
    "box_xyxy": ("float64", (4,)),
    "place_m": ("float64", (3,)),
    "T_world_camera": ("float64", (4, 4)),
    "error_px": ("float64", ()),
    "command": ("float64", (4,)),
    **{f"reward_{term}": ("float64", ()) for term in TERMS},
}
"""Key -> dtype and shape of what it holds."""


def truth_info(
    frame: Frame,
    estimate: Estimate,
    obeyed: CameraCommand,
    terms: Mapping[str, float],
    episode_seed: int,
) -> dict[str, Any]:
    """Return the info of one step.

    ``state`` is the index in ``in, partial, occluded, out``; ``position_px``, ``box_xyxy`` and ``T_world_camera`` are
    true; ``error_px`` is the tracker's, NaN where it says nothing; ``command`` is the one obeyed (forward, right and
    climb in m/s, yaw rate in rad/s); ``reward_TERM`` are the reward's terms, 0 after a reset.
    """
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
