"""The ``info`` of envs: truth, for scoring. Every step has the same keys, with numbers or arrays of fixed shape.

Where truth has NaN, ``info`` has inf: checkers of envs compare infos, and a NaN equals no other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, get_args

import numpy as np

from scenarios.envs.reward import TERMS
from scenarios.envs.settings import OWN_WORLD
from scenarios.scenario import Frame
from scenarios.truth import Truth, VisibilityState, dtype_of, meanings
from scenarios.visibility import centring, is_in_view, length_px
from trackers.types import CameraCommand, CommandName, Estimate

_STATES = get_args(VisibilityState)
COMMANDS = get_args(CommandName)
NO_REWARD = dict.fromkeys(TERMS, 0.0)


@cache
def truth_keys(kind: type[Truth]) -> dict[str, tuple[str, tuple[int, ...], str]]:
    """Return the numeric fields of a kind of ``Truth`` about the frame and the target, in the form of ``INFO``."""
    keys = {}
    for name, meaning in meanings(kind).items():
        if meaning.table in ("", "standing") or meaning.unit == "word" or dtype_of(kind, name).hasobject:
            continue
        shape = tuple(int(size) for size in (meaning.shape[1:] if meaning.table == "objects" else meaning.shape))
        coding = meaning.coding.replace("NaN", "inf")
        words = ("of the target" if meaning.table == "objects" else "", meaning.unit.removeprefix("1"), coding)
        keys[name] = (dtype_of(kind, name).name, shape, ", ".join(filter(None, words)))
    return keys


INFO: dict[str, tuple[str, tuple[int, ...], str]] = {
    "episode_seed": ("int64", (), "seed of the episode in the catalogue"),
    "world_seed": ("int64", (), "seed of the world in which the episode takes place; -1: its own, as in the catalogue"),
    **truth_keys(Truth),
    "state": ("int64", (), f"index of the target's state in {', '.join(_STATES)}"),
    "in_view": (
        "bool",
        (),
        "target's centre in the picture, hidden or not, as large as its scene asks (at least 12 px of 320)",
    ),
    "centring": ("float64", (), "1 with the target in the middle of the picture, 0 on its border and outside"),
    "length_px": ("float64", (), "longer side of the target's true box in pixels; 0 behind the camera"),
    "place_m": ("float64", (3,), "target's true place in the world, in metres"),
    "error_px": (
        "float64",
        (),
        "distance in pixels of the tracker's estimate from the true centre, in the picture that it saw; inf without "
        "one; no key with tracker=None",
    ),
    "command": ("float64", (len(COMMANDS),), f"command obeyed: {', '.join(COMMANDS)}"),
    **{f"reward_{term}": ("float64", (), "weighted term of the step's reward; 0 after a reset") for term in TERMS},
}
"""Key -> dtype, shape and description of its value. If there are two cameras, truth is that of the steered one. Numbers
that a scene's own kind of ``Truth`` has besides are in the ``info`` of its env too, see ``truth_keys``.
"""


def info_dtype(kind: Any, has_tracker: bool) -> np.dtype[Any]:
    """Return the record of an info with a kind of ``Truth``."""
    keys = {name: key for name, key in (INFO | truth_keys(kind)).items() if has_tracker or name != "error_px"}
    return np.dtype([(name, dtype, shape) for name, (dtype, shape, _) in keys.items()], align=True)


def truth_info(
    frame: Frame,
    target: int,
    answered: tuple[Frame, Estimate] | None,
    obeyed: CameraCommand,
    terms: Mapping[str, float],
    episode_seed: int,
    world_seed: int = OWN_WORLD,
    widest_view_m: float = np.inf,
) -> dict[str, Any]:
    """Return the info of one step for the object ``target``, see ``INFO``.

    Args:
        answered: the frame that the tracker saw, and its estimate there; None without a tracker.
        terms: those of the reward.
        widest_view_m: see ``Scenario``.
    """
    truth, camera = frame.judged
    kind: Any = type(truth)
    error = {}
    if answered is not None:
        seen, estimate = answered
        off_px = estimate.position_px - seen.truth.position_px[target]
        error["error_px"] = _plain(math.sqrt(off_px @ off_px))
    return {
        "episode_seed": episode_seed,
        "world_seed": world_seed,
        **{
            name: _plain(getattr(truth, name)[target] if per_object else getattr(truth, name))
            for name, per_object in _is_per_object(kind).items()
        },
        "state": _STATES.index(truth.state[target]),
        "in_view": is_in_view(truth, target, camera, widest_view_m),
        "centring": centring(truth, target, camera),
        "length_px": length_px(truth, target),
        "place_m": truth.T_world_object[target, :3, 3].copy(),
        **error,
        "command": np.array([getattr(obeyed, name) for name in COMMANDS]),
        **{f"reward_{term}": terms[term] for term in TERMS},
    }


@cache
def _is_per_object(kind: Any) -> dict[str, bool]:
    return {name: meanings(kind)[name].table == "objects" for name in truth_keys(kind)}


def _plain(value: Any) -> Any:
    """Return a copy of an array, or a Python number, with inf in place of NaN."""
    if isinstance(value, np.ndarray) and value.ndim:
        array = value.copy()
        if array.dtype.kind == "f":
            array[np.isnan(array)] = np.inf
        return array
    number = value.item() if isinstance(value, _OF_NUMPY) else value
    return math.inf if number != number else number


_OF_NUMPY = np.ndarray, np.generic
