"""The link from who steers to what is steered: limits, delay and noise on the way."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from sim.checks import check
from trackers.types import CameraCommand, Carrier


@dataclass(frozen=True)
class Link:
    """What happens to a command on its way.

    Attributes:
        delay_frames: a command given on one picture moves the carrier so many frames later than the next, >= 0.
        noise: standard deviation of what is added to each number, as a share of its limit, >= 0.
    """

    delay_frames: int = 0
    noise: float = 0.0

    def __post_init__(self) -> None:
        good = isinstance(self.delay_frames, int) and self.delay_frames >= 0
        check("delay_frames", good, "a whole number >= 0", self.delay_frames)
        check("noise", 0.0 <= self.noise < np.inf, "a finite number >= 0", self.noise)


LINKS = {"prompt": Link(), "delayed": Link(delay_frames=3), "noisy": Link(noise=0.1)}
"""Presets by name."""


def link_named(name: str) -> Link:
    """Return a preset. Raises ValueError for an unknown name."""
    check("link", name in LINKS, f"one of {', '.join(LINKS)}", repr(name))
    return LINKS[name]


class CommandLink:
    """Passes commands on as the carrier gets them; one for each episode.

    A command's numbers are limited to the carrier's range, and to what they may change from frame to frame; then they
    wait their turn, and noise is added. Numbers that the carrier does not obey are dropped.
    """

    def __init__(self, carrier: Carrier, rate_hz: float, link: Link, rng: np.random.Generator) -> None:
        self._carrier = carrier
        self._noise, self._rng = link.noise, rng
        self._limits = np.array([axis.limit for axis in carrier.axes])
        self._steps = np.array([axis.slew_per_s for axis in carrier.axes]) / rate_hz
        self._latest = np.zeros(len(carrier.axes))
        self._waiting = deque([np.zeros(len(carrier.axes))] * link.delay_frames)

    def send(self, command: CameraCommand) -> CameraCommand:
        """Return what the carrier gets on this frame.

        Raises:
            ValueError: if the command is not finite.
        """
        wanted = np.array([getattr(command, axis.name) for axis in self._carrier.axes], dtype=float)
        check("command", bool(np.isfinite(wanted).all()), "finite numbers", command)
        wanted = np.clip(wanted, -self._limits, self._limits)
        self._latest = np.clip(wanted, self._latest - self._steps, self._latest + self._steps)
        self._waiting.append(self._latest)
        obeyed = self._waiting.popleft()
        if self._noise > 0.0:
            obeyed = obeyed + self._noise * self._limits * self._rng.normal(size=len(obeyed))
            obeyed = np.clip(obeyed, -self._limits, self._limits)
        return CameraCommand(**{axis.name: float(v) for axis, v in zip(self._carrier.axes, obeyed, strict=True)})
