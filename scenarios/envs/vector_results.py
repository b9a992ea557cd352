"""What vector envs with and without pictures have in common: options of resets, and infos as Gymnasium has them."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from scenarios.envs.observing import Observed
from sim.checks import check


def check_open(envs: gym.vector.VectorEnv[Any, Any, Any]) -> None:
    """Raise ClosedEnvironmentError for envs that are closed."""
    if envs.closed:
        raise gym.error.ClosedEnvironmentError("vector env: expected it to be open, got a closed one")


def checked_mask(mask: Any, count: int, begun: bool) -> NDArray[np.bool_]:
    """Return the option ``reset_mask`` (N,), every env without it. Raises ValueError for no mask of some envs.

    Args:
        begun: whether all envs have had a reset.
    """
    if mask is None:
        return np.ones(count, dtype=bool)
    good = isinstance(mask, np.ndarray) and (mask.dtype, mask.shape) == (np.dtype(bool), (count,))
    check("reset_mask", good and mask.any(), f"an array ({count},) of bool, True for one or more", repr(mask))
    check("reset_mask", begun or mask.all(), "every env in the first reset", repr(mask))
    return mask.copy()


def masked(infos: dict[str, NDArray[Any]], mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return an array for each key, 0 outside the mask (N,), and the mask as ``_key``."""
    found: dict[str, Any] = {}
    for name, array in infos.items():
        array[~mask] = 0
        found[name], found[f"_{name}"] = array, mask.copy()
    return found


def final_infos(last: Observed, infos: dict[str, NDArray[Any]], ended: NDArray[np.bool_]) -> dict[str, Any]:
    """Return ``final_obs`` and ``final_info`` of the envs ``ended`` (N,), of the last observations and infos of all."""
    seen = np.full(len(ended), None, dtype=object)
    for k in np.flatnonzero(ended):
        seen[k] = {name: each[k] for name, each in last.items()} if isinstance(last, dict) else last[k]
    final = {"final_obs": seen, "final_info": masked(infos, ended)}
    return final | {f"_{name}": ended.copy() for name in final}
