"""The reward of a step: a weighted sum of terms; ``info`` holds each term."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import Frame
from scenarios.visibility import centring, is_in_view, length_px, shortest_length_px
from sim.checks import check, check_choice

TERMS = ("in_view", "centred", "size", "effort", "loss")


@dataclass(frozen=True)
class Reward:
    """Weights of the reward's terms; each term is its weight times the value below.

    Attributes:
        in_view: 1 while the target's centre is in the picture and it is shown as large as its scene asks (at least 12
            pixels long, in a picture of 320 or more), else 0.
        centred: tanh(4 p³), where p is 1 in the middle of the picture and 0 on its border and outside (the reward of
            DAT_Benchmark).
        size: while in view exp(-ln²(length / wanted length) / 2), which is 1 for a length of `length_share` of the
            picture's width.
        effort: minus the root mean square of the obeyed command's numbers, each over its limit.
        loss: -1 on the step at which the target has been out of view for `loss_after_s`, else 0.
        length_share: wanted length in `size`, in widths of the picture.
        loss_after_s: time out of view in `loss`, in seconds.
    """

    in_view: float = 1.0
    centred: float = 0.2
    size: float = 0.0
    effort: float = 0.1
    loss: float = 1.0
    length_share: float = 0.12
    loss_after_s: float = 1.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            positive = name not in TERMS
            good = isinstance(value, int | float | np.number) and np.isfinite(value) and (value > 0 or not positive)
            check(f"reward.{name}", bool(good), f"a finite number{' > 0' if positive else ''}", repr(value))


def reward_of(weights: Any) -> Reward:
    """Return a ``Reward``, made from a mapping of fields; the others keep their defaults. Raises ValueError if none."""
    if isinstance(weights, Reward):
        return weights
    check("reward", isinstance(weights, Mapping), "a Reward, or a mapping of its fields", repr(weights))
    for name in weights:
        check_choice("reward", name, [each.name for each in fields(Reward)])
    return Reward(**weights)


def effort_of(shares: NDArray[np.float64]) -> float:
    """Return the root mean square of a command's numbers (A,), each over its limit; 0 without any."""
    return math.sqrt(shares @ shares) / math.sqrt(max(len(shares), 1))


class Rewarder:
    """Rewards the steps of one episode."""

    def __init__(self, reward: Reward, rate_hz: float, widest_view_m: float = np.inf) -> None:
        """``widest_view_m``: see ``scenarios.scenario.Scenario``."""
        self._reward, self._widest_view_m = reward, widest_view_m
        self._loss_frames = max(round(reward.loss_after_s * rate_hz), 1)
        self.frames_out = 0

    def terms(self, frame: Frame, target: int, effort: float) -> dict[str, float]:
        """Add a frame and return its weighted terms for the object ``target``; ``effort`` is in [0, 1]."""
        reward, (truth, camera) = self._reward, frame.judged
        seen = is_in_view(truth, target, camera, self._widest_view_m)
        self.frames_out = 0 if seen else self.frames_out + 1
        length = max(length_px(truth, target), shortest_length_px(camera.width_px))
        length /= reward.length_share * camera.width_px
        return {
            "in_view": reward.in_view * float(seen),
            "centred": reward.centred * float(np.tanh(4.0 * centring(truth, target, camera) ** 3)),
            "size": reward.size * float(np.exp(-0.5 * np.log(length) ** 2)) * float(seen),
            "effort": -reward.effort * effort,
            "loss": -reward.loss * float(self.frames_out == self._loss_frames),
        }
