"""Quality of a camera's following: our metrics, and those of comparable benchmarks.

Frames, steps and *in view* are defined in ``benchmarks.judges.view_time``. Shares and means are over the steps, frames
1 to F - 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.view_time import find_losses
from scenarios.truth import Truth

RIVALS_LOSS_S = 2.0
"""The rivals' episodes end with a loss after a wall-clock time out of view; here it is this simulated time."""
RIVALS_STEPS = 500
FOLLOWING_M, FAR_M, FAR_STEPS, COLLISION_M = 3.0, 4.0, 20, 0.5


def centring_error(position_px: NDArray[np.float64], size_px: tuple[int, int], in_view: NDArray[np.bool_]) -> float:
    """Return the mean of ``|target - middle| / (half the picture's diagonal)`` in [0, 1] over the steps in view.

    Args:
        position_px: (F, 2) the target's centre. size_px: (width, height).

    Returns:
        NaN if the target never was in view.
    """
    size = np.array(size_px)
    distance = np.linalg.norm(position_px - 0.5 * size, axis=1) / (0.5 * np.linalg.norm(size))
    among = distance[1:][in_view[1:]]
    return float(among.mean()) if len(among) else float("nan")


def effort(shares: NDArray[np.float64]) -> float:
    """Return ``mean_k |c_k| / sqrt(A)`` in [0, 1] of the obeyed commands c (F - 1, A), in shares of the axes' limits.

    0: no commands; 1: every axis at its limit all the time.
    """
    return float(np.linalg.norm(shares, axis=1).mean() / np.sqrt(shares.shape[1]))


def jerkiness_per_s(shares: NDArray[np.float64], rate_hz: float) -> float:
    """Return ``rate * mean_k |c_k - c_(k-1)| / sqrt(A)`` >= 0 of the obeyed commands c (F - 1, A), from rest."""
    changes = np.diff(shares, axis=0, prepend=np.zeros((1, shares.shape[1])))
    return float(rate_hz * np.linalg.norm(changes, axis=1).mean() / np.sqrt(shares.shape[1]))


def is_on_target(position_px: NDArray[np.float64], truth: Truth, target: int) -> bool:
    """Return whether a position (2,) is within the target's amodal box, in the picture or outside."""
    box = truth.box_xyxy[target]
    return bool((position_px >= box[:2]).all() and (position_px < box[2:]).all())


def is_on_other(position_px: NDArray[np.float64], truth: Truth, target: int) -> bool:
    """Return whether the pixel at a position (2,) shows another object and the position is outside the target's box."""
    height, width = truth.instance_map.shape
    if not (0 <= position_px[0] < width and 0 <= position_px[1] < height) or is_on_target(position_px, truth, target):
        return False
    shown = truth.instance_map[int(position_px[1]), int(position_px[0])]
    return bool(shown != truth.instance_id[target] and (shown == truth.instance_id).any())


def dat_cumulative_reward(centring: NDArray[np.float64]) -> float:
    """Return ``CR = sum_k tanh(4 p_k^3)`` over the steps, in [0, 0.9993 (F - 1)]: it grows with the episode.

    DAT_Benchmark (NeurIPS 2025). Its p (F,) in [0, 1] is ``scenarios.visibility.centring``: one minus the target's
    distance from the picture's middle over that of the edge along the same ray; 0 outside. The target's size has no
    influence.
    """
    return float(np.tanh(4.0 * centring[1:] ** 3).sum())


def dat_tsr(centring: NDArray[np.float64]) -> float:
    """Return the tracking success rate: mean of ``1[p_k > 0]`` over the steps, in [0, 1] (ibid.)."""
    return float((centring[1:] > 0).mean())


def episode_length_steps(in_view: NDArray[np.bool_], rate_hz: float) -> int:
    """Return the steps until the target counts as lost, or of the whole episode (AD-VAT, UnrealZoo).

    There the target is lost after some wall-clock seconds out of view; here after two simulated seconds.
    """
    lost = find_losses(in_view, rate_hz, RIVALS_LOSS_S)
    return lost[0].first_frame + int(RIVALS_LOSS_S * rate_hz) if lost else len(in_view) - 1


def survives(in_view: NDArray[np.bool_], rate_hz: float, steps: int = RIVALS_STEPS) -> bool:
    """Return whether the first ``steps`` steps, or the whole of a shorter episode, have no such loss.

    SR_500 is the share of such episodes (ibid.).
    """
    return not find_losses(in_view[: steps + 1], rate_hz, RIVALS_LOSS_S)


@dataclass(frozen=True, slots=True)
class PersonFollowing:
    """EVT-Bench's scores of an episode.

    Attributes:
        success: following on the last step. collision: the episode ended with one, nearer than 0.5 m.
        tracking_rate: share of the steps following, in [0, 1].
    """

    success: bool
    tracking_rate: float
    collision: bool


def person_following(in_picture: NDArray[np.bool_], distance_m: NDArray[np.float64]) -> PersonFollowing:
    """Return the scores of EVT-Bench (TrackVLA, 2025) for an episode.

    Following: the camera faces the person (here: the centre is in the picture) from at most 3 m. Their episode ends
    with a collision, or with the loss of the person: more than 20 steps beyond 4 m since the last step of following.
    Ours continues, with no further following. Their tracking rate divides by the larger of reference length and steps;
    here all episodes have the same length, F - 1.

    Args:
        in_picture: (F,). distance_m: (F,) on the ground from the camera to the person.
    """
    following = in_picture & (distance_m <= FOLLOWING_M)
    far_steps, collision = 0, False
    for step in range(1, len(following)):
        far_steps = 0 if following[step] else far_steps + bool(distance_m[step] > FAR_M)
        collision = bool(distance_m[step] < COLLISION_M)
        if far_steps > FAR_STEPS or collision:
            following[step:] = False
            break
    steps = following[1:]
    return PersonFollowing(bool(steps[-1]), float(steps.mean()), collision)
