"""The plans of the controller ``omniscient``, tried in the world without pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.command_link import Link, link_limits
from scenarios.envs.pictureless.bank import episode_bank, pictureless_of
from scenarios.envs.pictureless.error_kernel import ERRORS
from scenarios.envs.pictureless.vector_env import terms_of, weights_of
from scenarios.envs.reward import TERMS, Reward
from scenarios.visibility import MOSTLY_SEEN
from trackers.belief.kernel import SIGHTING

_KNOT_FRAMES = 3
_OUTSIDE = 0.05
"""Cost of a target outside the picture, for each half of the picture to its border; at most three count."""
_VISIBLE = 0.3
"""Worth of the target's visible share, beside that of its being seen: plans that show more of it are nearer to that."""
_FAR, _NEAR_M = 0.1, 2.5
"""Cost of each metre of distance beyond the second, under a camera that looks ahead: walls and people fit between."""


class Planner:
    """Improves a plan on every picture, on a twin of the carrier, see ``OmniscientController``.

    Attributes:
        commands: see ``Carrier``.
        shares: (T, A) the plan, in shares of the limits.
    """

    def __init__(self, parameters: Any, scenario: str, configuration: Any, seed: int, link: Link) -> None:
        """``parameters``: ``OmniscientParameters``. Raises ValueError for a scenario without such a world."""
        self._parameters, p = parameters, parameters
        self._rng = np.random.Generator(np.random.PCG64(0))
        bank = episode_bank(scenario, configuration, [seed])
        carrier = catalog.scenario(scenario).carrier
        self.commands = carrier.commands
        limits = link_limits(carrier, configuration.rate_hz, link, self.commands)
        # The tracker without pictures, whose answers nobody reads.
        self._world = pictureless_of(scenario).world(configuration, bank.arrays, limits, np.zeros(1, ERRORS))
        self._looks_ahead = carrier.looks == "ahead"
        self._last, self._limits = bank.frame_count - 1, limits.limits
        self._steered = np.flatnonzero(limits.limits)
        self._delayed = np.zeros((1, limits.delay_frames, len(self.commands)))
        self._twin, self._sightings = np.zeros(1, self._world.state_dtype), np.zeros(p.plans, SIGHTING)
        self._world.begin(self._twin, np.zeros(1, int), np.zeros(1, int), False, self._sightings, self._rng)
        self.shares = np.zeros((p.horizon_frames, len(self._steered)))
        self._weights, self._terms = weights_of(Reward(loss=0.0)), np.zeros((p.plans, len(TERMS)))
        self._given: NDArray[np.float64] | None = None

    def command(self) -> NDArray[np.float64]:
        """Return the numbers (4,) of the next command, ``commands``."""
        if self._given is not None:
            self._move(self._twin, self._given[None], self._delayed)
        self.improve()
        self._given = np.zeros(len(self.commands))
        self._given[self._steered] = self.shares[0] * self._limits[self._steered]
        self.shares = np.concatenate([self.shares[1:], self.shares[-1:]])
        return self._given

    def _move(self, states: NDArray[np.void], wanted: NDArray[np.float64], delayed: NDArray[np.float64]) -> None:
        self._world.move(states, wanted, delayed, self._sightings, self._rng)

    def improve(self) -> None:
        """Move the planned shares of the limits (T, A) to better ones."""
        p = self._parameters
        frames = min(p.horizon_frames, self._last - int(self._twin["frame"][0]))
        spread = np.full_like(self.shares, p.spread)
        knots = -(-p.horizon_frames // _KNOT_FRAMES)
        for _ in range(p.rounds if frames > 0 else 0):
            noise = self._rng.standard_normal((p.plans, knots, len(self._steered)))
            noise = np.repeat(noise, _KNOT_FRAMES, axis=1)[:, : p.horizon_frames]
            noise[0] = 0.0
            plans = np.clip(self.shares + spread * noise, -1.0, 1.0)
            best = np.argsort(-self.worth(plans, frames))[: round(p.best * p.plans)]
            self.shares, spread = plans[best].mean(axis=0), np.maximum(plans[best].std(axis=0), 0.1 * p.spread)

    def worth(self, plans: NDArray[np.float64], frames: int) -> NDArray[np.float64]:
        """Return the worth (K,) of plans (K, T, A) over so many frames."""
        states, delayed = np.repeat(self._twin, len(plans)), np.repeat(self._delayed, len(plans), axis=0)
        wanted, worth = np.zeros((len(plans), len(self.commands))), np.zeros(len(plans))
        _, half_width_px, half_height_px = self._world.camera
        for t in range(frames):
            wanted[:, self._steered] = plans[:, t] * self._limits[self._steered]
            self._move(states, wanted, delayed)
            terms_of(states, self._weights, 0, 2.0 * half_width_px, self._limits, self._terms)
            off = np.abs(states["target_px"] / (half_width_px, half_height_px) - 1.0).max(axis=1) - 1.0
            worth += self._terms.sum(axis=1) - _OUTSIDE * np.clip(np.nan_to_num(off, nan=3.0), 0.0, 3.0)
            worth += (states["visible"] >= MOSTLY_SEEN) + _VISIBLE * states["visible"]
            if self._looks_ahead:
                far_m = np.linalg.norm(states["target_m"][:, :2] - states["camera_m"][:, :2], axis=1) - _NEAR_M
                worth -= _FAR * np.maximum(far_m, 0.0)
        return worth
