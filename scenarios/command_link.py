"""The link from who steers to what is steered: limits, delay and noise on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.checks import check
from sim.rng import generator
from trackers.types import BODY_COMMANDS, CameraCommand, Carrier, CommandName


def link_fields(count: int) -> list[tuple[Any, ...]]:
    """Return what a record must have that commands of ``count`` numbers are sent to: steps so far, the latest command
    after limits, the one obeyed.
    """
    return [("steps", "i8"), ("command", "f8", (count,)), ("obeyed", "f8", (count,))]


LINK_FIELDS = link_fields(len(BODY_COMMANDS))
"""Those of the commands of a carrier that moves as a whole."""


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


@dataclass(frozen=True, eq=False)
class LinkLimits:
    """A link to a carrier, for kernels.

    Attributes:
        limits, steps: (A,) range and largest change a frame of each command, 0 of those that the carrier does not obey.
        delay_frames, noise: see ``Link``.
    """

    limits: NDArray[np.float64]
    steps: NDArray[np.float64]
    delay_frames: int
    noise: float


def link_limits(
    carrier: Carrier, rate_hz: float, link: Link, names: tuple[CommandName, ...] = BODY_COMMANDS
) -> LinkLimits:
    """Return the numbers of a link to a carrier, of the commands of these names in this order."""
    axes = {axis.name: axis for axis in carrier.axes}
    limits = [axes[name].limit if name in axes else 0.0 for name in names]
    steps = [axes[name].slew_per_s / rate_hz if name in axes else 0.0 for name in names]
    return LinkLimits(np.array(limits), np.array(steps), link.delay_frames, link.noise)


class CommandLink:
    """Passes commands on as the carrier gets them; one for each episode.

    A command's numbers are limited to the carrier's range, and to what they may change from frame to frame; then they
    wait their turn, and noise is added. Numbers that the carrier does not obey are dropped.
    """

    def __init__(self, carrier: Carrier, rate_hz: float, link: Link, rng: np.random.Generator) -> None:
        self._names = tuple(axis.name for axis in carrier.axes)
        self._link, self._rng = link_limits(carrier, rate_hz, link, self._names), rng
        count = len(self._names)
        self._state = np.zeros(1, np.dtype(link_fields(count), align=True))
        self._waiting = np.zeros((link.delay_frames, count))

    def send(self, command: CameraCommand) -> CameraCommand:
        """Return what the carrier gets on this frame.

        Raises:
            ValueError: if the command is not finite.
        """
        wanted = np.array([getattr(command, name) for name in self._names], dtype=float)
        check("command", bool(np.isfinite(wanted).all()), "finite numbers", command)
        link = self._link
        _send_one(self._state, wanted, link.limits, link.steps, self._waiting, link.noise, self._rng)
        obeyed = self._state["obeyed"][0]
        return CameraCommand(**{name: float(number) for name, number in zip(self._names, obeyed, strict=True)})


@njit(cache=True)
def send(
    life: Any,
    wanted: NDArray[np.float64],
    limits: NDArray[np.float64],
    steps: NDArray[np.float64],
    waiting: NDArray[np.float64],
    noise: float,
    rng: np.random.Generator,
) -> None:
    """Write the command that the carrier gets to ``life.obeyed``; see ``CommandLink``.

    Args:
        life: a record with ``LINK_FIELDS``.
        wanted: (A,) the commands.
        limits, steps, noise: see ``LinkLimits``.
        waiting: (D, A) commands on their way, a ring whose place is the number of steps.
    """
    delay = len(waiting)
    for axis in range(len(limits)):
        value = min(max(wanted[axis], -limits[axis]), limits[axis])
        value = min(max(value, life.command[axis] - steps[axis]), life.command[axis] + steps[axis])
        life.command[axis] = value
        if delay > 0:
            place = life.steps % delay
            value, waiting[place, axis] = waiting[place, axis], value
        if noise > 0.0 and limits[axis] > 0.0:
            value += noise * limits[axis] * rng.standard_normal()
            value = min(max(value, -limits[axis]), limits[axis])
        life.obeyed[axis] = value


@njit(cache=True)
def _send_one(
    states: Any,
    wanted: NDArray[np.float64],
    limits: NDArray[np.float64],
    steps: NDArray[np.float64],
    waiting: NDArray[np.float64],
    noise: float,
    rng: np.random.Generator,
) -> None:
    send(states[0], wanted, limits, steps, waiting, noise, rng)
    states[0].steps += 1


def episode_link(carrier: Carrier, rate_hz: float, link: Link, seed: int) -> CommandLink:
    """Return the link of one episode: its noise is the same whoever steers, wherever it is lived through."""
    return CommandLink(carrier, rate_hz, link, generator(seed, "link"))
