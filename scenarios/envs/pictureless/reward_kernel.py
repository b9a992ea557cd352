"""Rewards of many envs at a time, with the equations of ``scenarios.envs.reward.Rewarder``.

``Rewarder`` does not use this kernel: NumPy's tanh, exp and log differ from compiled ones in the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scenarios.envs.reward import Reward
from scenarios.in_view import SHORTEST_LENGTH_PX

IN_VIEW, CENTRED, SIZE, EFFORT, LOSS, LENGTH_SHARE = range(6)


def weights_of(reward: Reward) -> NDArray[np.float64]:
    """Return the weights (6,) of a reward as ``terms_of`` reads them."""
    return np.array([reward.in_view, reward.centred, reward.size, reward.effort, reward.loss, reward.length_share])


@njit(cache=True)
def terms_of(
    states: Any,
    weights: NDArray[np.float64],
    loss_frames: int,
    width_px: float,
    limits: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the weighted terms (B, 5) of a step, in the order of ``scenarios.envs.reward.TERMS``."""
    for k in range(len(states)):
        state = states[k]
        effort, axes = 0.0, 0
        for axis in range(len(limits)):
            if limits[axis] > 0.0:
                effort += min((state.obeyed[axis] / limits[axis]) ** 2, 1.0)
                axes += 1
        length = max(state.length_px, SHORTEST_LENGTH_PX) / (weights[LENGTH_SHARE] * width_px)
        out[k, 0] = weights[IN_VIEW] * state.in_view
        out[k, 1] = weights[CENTRED] * np.tanh(4.0 * state.centring**3)
        out[k, 2] = weights[SIZE] * np.exp(-0.5 * np.log(length) ** 2) * state.in_view
        out[k, 3] = -weights[EFFORT] * np.sqrt(effort / axes)
        out[k, 4] = -weights[LOSS] if state.frames_out == loss_frames else 0.0
