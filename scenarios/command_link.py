"""The link between a controller and the carrier: limits, delay and noise of commands, delay of pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.rng import generator
from trackers.kernels.records import record_kernel
from trackers.types import BODY_COMMANDS, CameraCommand, Carrier, CommandName


def link_fields(count: int) -> list[tuple[Any, ...]]:
    """Return the link's fields in a record: steps so far, the latest command (count,) after limits, the one obeyed."""
    return [("steps", "i8"), ("command", "f8", (count,)), ("obeyed", "f8", (count,))]


LINK_FIELDS = link_fields(len(BODY_COMMANDS))
"""The link's fields for a carrier that moves as a whole."""


@dataclass(frozen=True)
class Link:
    """Delay and noise of commands, and delay of pictures.

    Attributes:
        delay_frames: frames by which a command is late; 0: it moves the carrier before the next picture.
        noise: standard deviation of the noise on each number, as a share of its limit, >= 0.
        picture_delay_frames: frames by which a picture is late, and with it all else that tracker, controller and
            policy observe; until then they see the first one. Truth and reward are those of the present.
    """

    delay_frames: int = 0
    noise: float = 0.0
    picture_delay_frames: int = 0

    def __post_init__(self) -> None:
        for name in ("delay_frames", "picture_delay_frames"):
            frames = getattr(self, name)
            good = isinstance(frames, int) and not isinstance(frames, bool) and frames >= 0
            check(name, good, "a whole number >= 0", frames)
        check("noise", 0.0 <= self.noise < np.inf, "a finite number >= 0", self.noise)


LINKS = {
    "prompt": Link(),
    "delayed": Link(delay_frames=3),
    "noisy": Link(noise=0.1),
    "late": Link(picture_delay_frames=3),
}
"""Presets by name."""


def link_named(name: str) -> Link:
    """Return a preset. Raises ValueError for an unknown name."""
    check("link", name in LINKS, f"one of {', '.join(LINKS)}", repr(name))
    return LINKS[name]


class LinkLimits(NamedTuple):
    """A link to a carrier, for kernels.

    Attributes:
        limits, steps: (A,) largest value and largest change per frame of each command; 0 if the carrier ignores it.
        delay_frames, noise: see ``Link``.
    """

    limits: NDArray[np.float64]
    steps: NDArray[np.float64]
    delay_frames: int
    noise: float


def link_limits(carrier: Carrier, rate_hz: float, link: Link, names: tuple[CommandName, ...]) -> LinkLimits:
    """Return the limits of a link to a carrier, for the commands ``names`` in this order."""
    axes = {axis.name: axis for axis in carrier.axes}
    limits = [axes[name].limit if name in axes else 0.0 for name in names]
    steps = [axes[name].slew_per_s / rate_hz if name in axes else 0.0 for name in names]
    return LinkLimits(np.array(limits), np.array(steps), link.delay_frames, link.noise)


class CommandLink:
    """Passes commands on to the carrier; one link per episode.

    A command's numbers are limited in value and in change per frame, then delayed, then noise is added. Numbers that
    the carrier ignores are dropped.
    """

    def __init__(self, carrier: Carrier, rate_hz: float, link: Link, rng: np.random.Generator) -> None:
        self._names = tuple(axis.name for axis in carrier.axes)
        self._link, self._rng = link_limits(carrier, rate_hz, link, self._names), rng
        count = len(self._names)
        self._state = np.zeros(1, np.dtype(link_fields(count), align=True))
        self._waiting = np.zeros((link.delay_frames, count))

    def send(self, command: CameraCommand) -> CameraCommand:
        """Return the command that the carrier receives on this frame.

        Raises:
            ValueError: if the command is not finite.
        """
        wanted = np.array([getattr(command, name) for name in self._names], dtype=float)
        check("command", all(map(math.isfinite, wanted.tolist())), "finite numbers", command)
        _send_one(self._state, wanted, self._link, self._waiting)
        # A generator takes a tenth of a millisecond on its way to a kernel.
        if self._link.noise > 0.0:
            _disturb_one(self._state, self._link, self._rng)
        obeyed = self._state["obeyed"][0]
        return CameraCommand(**{name: float(number) for name, number in zip(self._names, obeyed, strict=True)})


@record_kernel()
def send(
    state: Any,
    wanted: NDArray[np.float64],
    link: LinkLimits,
    waiting: NDArray[np.float64],
    rng: np.random.Generator,
) -> None:
    """Write the command that the carrier receives to ``state.obeyed``; see ``CommandLink``.

    Args:
        state: a record with ``LINK_FIELDS``.
        wanted: (A,) the command.
        waiting: (D, A) delayed commands, a ring buffer indexed by ``steps % D``.
    """
    _limit_and_delay(state, wanted, link, waiting)
    if link.noise > 0.0:
        _add_noise(state, link, rng)


@record_kernel()
def _limit_and_delay(state: Any, wanted: NDArray[np.float64], link: LinkLimits, waiting: NDArray[np.float64]) -> None:
    limits, steps, delay = link.limits, link.steps, len(waiting)
    for axis in range(len(limits)):
        value = min(max(wanted[axis], -limits[axis]), limits[axis])
        value = min(max(value, state.command[axis] - steps[axis]), state.command[axis] + steps[axis])
        state.command[axis] = value
        if delay > 0:
            place = state.steps % delay
            value, waiting[place, axis] = waiting[place, axis], value
        state.obeyed[axis] = value


@record_kernel()
def _add_noise(state: Any, link: LinkLimits, rng: np.random.Generator) -> None:
    for axis in range(len(link.limits)):
        limit = link.limits[axis]
        if limit > 0.0:
            value = state.obeyed[axis] + link.noise * limit * rng.standard_normal()
            state.obeyed[axis] = min(max(value, -limit), limit)


@record_kernel()
def _send_one(states: Any, wanted: Any, link: LinkLimits, waiting: Any) -> None:
    _limit_and_delay(states[0], wanted, link, waiting)
    states[0].steps += 1


@record_kernel()
def _disturb_one(states: Any, link: LinkLimits, rng: np.random.Generator) -> None:
    _add_noise(states[0], link, rng)


def episode_link(carrier: Carrier, rate_hz: float, link: Link, seed: int) -> CommandLink:
    """Return the link of one episode. Its noise depends on the seed alone, not on the controller or the caller."""
    return CommandLink(carrier, rate_hz, link, generator(seed, "link"))
