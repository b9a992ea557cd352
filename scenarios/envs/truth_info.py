"""The ``info`` of envs: truth, for scoring. Every step has the same keys, with numbers or arrays of fixed shape."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

import numpy as np

from scenarios.envs.reward import TERMS
from scenarios.in_view import centring, is_in_view, length_px
from scenarios.scenario import Frame
from scenarios.truth import Truth, VisibilityState, dtype_of, meanings
from trackers.types import CameraCommand, CommandName, Estimate

_STATES = get_args(VisibilityState)
COMMANDS = get_args(CommandName)
NO_REWARD = dict.fromkeys(TERMS, 0.0)


def _truth_fields() -> dict[str, tuple[str, tuple[int, ...], str]]:
    """Return the numeric fields of ``Truth`` about the frame and the target: key -> dtype, shape and description."""
    fields = {}
    for name, meaning in meanings(Truth).items():
        if meaning.per_pixel or meaning.unit == "word":
            continue
        shape = tuple(int(size) for size in (meaning.shape[1:] if meaning.per_object else meaning.shape))
        words = ("of the target" if meaning.per_object else "", meaning.unit.removeprefix("1"), meaning.coding)
        fields[name] = (dtype_of(Truth, name).name, shape, ", ".join(filter(None, words)))
    return fields


_TRUTH_FIELDS = _truth_fields()
INFO: dict[str, tuple[str, tuple[int, ...], str]] = {
    "episode_seed": ("int64", (), "seed of the episode in the catalogue"),
    **_TRUTH_FIELDS,
    "state": ("int64", (), f"index of the target's state in {', '.join(_STATES)}"),
    "in_view": ("bool", (), "target's centre in the picture, hidden or not, and its box at least 12 pixels long"),
    "centring": ("float64", (), "1 with the target in the middle of the picture, 0 on its border and outside"),
    "length_px": ("float64", (), "longer side of the target's true box in pixels; 0 behind the camera"),
    "place_m": ("float64", (3,), "target's true place in the world, in metres"),
    "error_px": ("float64", (), "distance in pixels of the tracker's estimate from the true centre; NaN without one"),
    "command": ("float64", (len(COMMANDS),), f"command obeyed: {', '.join(COMMANDS)}"),
    **{f"reward_{term}": ("float64", (), "weighted term of the step's reward; 0 after a reset") for term in TERMS},
}
"""Key -> dtype, shape and description of its value. If there are two cameras, truth is that of the steered one."""


def truth_info(
    frame: Frame,
    target: int,
    estimate: Estimate,
    obeyed: CameraCommand,
    terms: Mapping[str, float],
    episode_seed: int,
) -> dict[str, Any]:
    """Return the info of one step for the object ``target``, see ``INFO``; ``terms`` are the reward's."""
    truth, camera = frame.judged
    error_px = np.asarray(estimate.position_px) - frame.truth.position_px[target]
    return {
        "episode_seed": episode_seed,
        **{name: _of_target(truth, target, name) for name in _TRUTH_FIELDS},
        "state": _STATES.index(truth.state[target]),
        "in_view": is_in_view(truth, target, camera),
        "centring": centring(truth, target, camera),
        "length_px": length_px(truth, target),
        "place_m": truth.T_world_object[target, :3, 3].copy(),
        "error_px": float(np.linalg.norm(error_px)),
        "command": np.array([getattr(obeyed, name) for name in COMMANDS]),
        **{f"reward_{term}": terms[term] for term in TERMS},
    }


_PER_OBJECT = {name: meaning.per_object for name, meaning in meanings(Truth).items()}


def _of_target(truth: Truth, target: int, name: str) -> Any:
    """Return a field of the frame or of the target: a copy of an array, or a Python number."""
    value = getattr(truth, name)
    value = value[target] if _PER_OBJECT[name] else value
    return value.copy() if np.ndim(value) else getattr(value, "item", lambda: value)()
