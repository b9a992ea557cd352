"""What a step is worth, for many at a time: the equations of ``scenarios.envs.reward.Rewarder``.

That one is not served by this kernel: NumPy's tanh, exp and log round other than compiled ones by a bit.
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
    """Return what ``terms_of`` reads of a reward (6,)."""
    return np.array([reward.in_view, reward.centred, reward.size, reward.effort, reward.loss, reward.length_share])


@njit(cache=True)
def terms_of(
    lives: Any,
    weights: NDArray[np.float64],
    loss_frames: int,
    width_px: float,
    limits: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the terms (B, 5) of a step, weights included, in the order of ``scenarios.envs.reward.TERMS``."""
    for k in range(len(lives)):
        life = lives[k]
        effort, axes = 0.0, 0
        for axis in range(len(limits)):
            if limits[axis] > 0.0:
                effort += min((life.obeyed[axis] / limits[axis]) ** 2, 1.0)
                axes += 1
        length = max(life.length_px, SHORTEST_LENGTH_PX) / (weights[LENGTH_SHARE] * width_px)
        out[k, 0] = weights[IN_VIEW] * life.in_view
        out[k, 1] = weights[CENTRED] * np.tanh(4.0 * life.centring**3)
        out[k, 2] = weights[SIZE] * np.exp(-0.5 * np.log(length) ** 2) * life.in_view
        out[k, 3] = -weights[EFFORT] * np.sqrt(effort / axes)
        out[k, 4] = -weights[LOSS] if life.frames_out == loss_frames else 0.0
