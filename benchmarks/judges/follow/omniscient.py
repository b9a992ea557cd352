"""The controller ``omniscient`` of the suite ``follow``: it knows the target's path and all that moves the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.command_link import Link, link_limits
from scenarios.envs.pictureless.bank import episode_bank, pictureless_of
from scenarios.envs.pictureless.episode_state import KernelWorld
from scenarios.envs.pictureless.error_kernel import ERRORS
from scenarios.envs.pictureless.vector_env import terms_of, weights_of
from scenarios.envs.reward import TERMS, Reward
from trackers.belief.kernel import SIGHTING
from trackers.controllers.catalogue import register_controller
from trackers.types import BODY_COMMANDS, CameraCommand, Estimate, Observation

_SUMMARY = "knows the target's path, the carrier's dynamics, and what moves the camera: what a controller could do"
_KNOT_FRAMES = 3
_OUTSIDE = 0.05
"""Cost of a target outside the picture, for each half of the picture to its border; at most three count."""


@dataclass(frozen=True)
class OmniscientParameters:
    """Settings of the search for the best commands.

    Attributes:
        horizon_frames: number of frames that are planned.
        plans: number of plans that are tried in each round. rounds: number of rounds.
        best: share of the plans whose mean the next round begins with.
        spread: standard deviation of the first round's plans, as a share of a command's limit.
    """

    horizon_frames: int = 30
    plans: int = 96
    rounds: int = 2
    best: float = 0.125
    spread: float = 0.3


@register_controller("omniscient", role="oracle", carrier="helicopter", summary=_SUMMARY)
@register_controller("omniscient", role="oracle", carrier="robot", summary=_SUMMARY)
class OmniscientController:
    """Plans with the episode's own dynamics by the cross-entropy method, and replans on every picture.

    It moves a twin of the carrier in the world without pictures, whose paths are those of the rendered one, and never
    looks at an estimate. A plan is worth the env's reward without ``loss``, less a cost of a target outside the picture
    that grows with its distance; the best plan of a picture is the first guess on the next one (Kobilarov,
    Cross-entropy motion planning, 2012).
    """

    Parameters = OmniscientParameters

    def __init__(self, parameters: OmniscientParameters) -> None:
        self.parameters = parameters
        self._rng = np.random.Generator(np.random.PCG64(0))
        self._world: KernelWorld | None = None

    def foresee(self, scenario: str, configuration: Any, seed: int, link: Link) -> None:
        """Take the episode that is to be steered. Raises ValueError for a scenario without dynamics of this kind."""
        carrier, p = catalog.scenario(scenario).carrier, self.parameters
        bank = episode_bank(scenario, configuration, [seed])
        limits = link_limits(carrier, configuration.rate_hz, link)
        # The tracker without pictures, whose answers nobody reads.
        self._world = pictureless_of(scenario).world(configuration, bank.arrays, limits, np.zeros(1, ERRORS))
        self._last, self._limits = bank.frame_count - 1, limits.limits
        self._steered = np.flatnonzero(limits.limits)
        self._delayed = np.zeros((1, limits.delay_frames, len(BODY_COMMANDS)))
        self._twin, self._sightings = np.zeros(1, self._world.state_dtype), np.zeros(p.plans, SIGHTING)
        self._world.begin(self._twin, np.zeros(1, int), np.zeros(1, int), False, self._sightings, self._rng)
        self._shares = np.zeros((p.horizon_frames, len(self._steered)))
        self._weights, self._terms = weights_of(Reward(loss=0.0)), np.zeros((p.plans, len(TERMS)))
        self._last_command: NDArray[np.float64] | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the first command of the best plan."""
        if self._last_command is not None:
            self._move(self._twin, self._last_command[None], self._delayed)
        self._improve()
        wanted = np.zeros(len(BODY_COMMANDS))
        wanted[self._steered] = self._shares[0] * self._limits[self._steered]
        self._shares = np.concatenate([self._shares[1:], self._shares[-1:]])
        self._last_command = wanted
        return CameraCommand(**dict(zip(BODY_COMMANDS, wanted.tolist(), strict=True)))

    def _move(self, states: NDArray[np.void], wanted: NDArray[np.float64], delayed: NDArray[np.float64]) -> None:
        assert self._world is not None
        self._world.move(states, wanted, delayed, self._sightings, self._rng)

    def _improve(self) -> None:
        """Move the planned shares of the limits (T, A) to better ones."""
        p = self.parameters
        frames = min(p.horizon_frames, self._last - int(self._twin["frame"][0]))
        spread = np.full_like(self._shares, p.spread)
        knots = -(-p.horizon_frames // _KNOT_FRAMES)
        for _ in range(p.rounds if frames > 0 else 0):
            noise = self._rng.standard_normal((p.plans, knots, len(self._steered)))
            noise = np.repeat(noise, _KNOT_FRAMES, axis=1)[:, : p.horizon_frames]
            noise[0] = 0.0
            plans = np.clip(self._shares + spread * noise, -1.0, 1.0)
            best = np.argsort(-self._worth(plans, frames))[: round(p.best * p.plans)]
            self._shares, spread = plans[best].mean(axis=0), np.maximum(plans[best].std(axis=0), 0.1 * p.spread)

    def _worth(self, plans: NDArray[np.float64], frames: int) -> NDArray[np.float64]:
        """Return the worth (K,) of plans (K, T, A) over so many frames."""
        states, delayed = np.repeat(self._twin, len(plans)), np.repeat(self._delayed, len(plans), axis=0)
        wanted, worth = np.zeros((len(plans), len(BODY_COMMANDS))), np.zeros(len(plans))
        assert self._world is not None
        _, half_width_px, half_height_px = self._world.camera
        for t in range(frames):
            wanted[:, self._steered] = plans[:, t] * self._limits[self._steered]
            self._move(states, wanted, delayed)
            terms_of(states, self._weights, 0, 2.0 * half_width_px, self._limits, self._terms)
            off = np.abs(states["target_px"] / (half_width_px, half_height_px) - 1.0).max(axis=1) - 1.0
            worth += self._terms.sum(axis=1) - _OUTSIDE * np.clip(np.nan_to_num(off, nan=3.0), 0.0, 3.0)
        return worth
