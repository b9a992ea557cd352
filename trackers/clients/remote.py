"""Trackers whose work a process of their own does: started by a command, kept from episode to episode."""

from __future__ import annotations

import os
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.clients import trax
from trackers.clients.child import Child, Limits
from trackers.clients.connection import Connection, SharedMemory, whole
from trackers.clients.trax import TraxTracker
from trackers.gaps import Bridge, Piece, Surroundings
from trackers.types import CameraModel, Estimate, Observation, SiteSurvey, Track


@dataclass(frozen=True)
class Program:
    """A program that serves trackers.

    Attributes:
        command: its words. environment: variables that it gets beside the usual ones, name and value.
        limits: what it may take.
    """

    command: tuple[str, ...]
    environment: tuple[tuple[str, str], ...] = ()
    limits: Limits = field(default_factory=Limits)


PORTABLE = Path(__file__).parent / "portable"
"""Folder of ``frameout_client.py`` and of adapters; processes can import from it, and nothing of ours is beside it."""
_IDLE: dict[Program, list[Connection]] = {}
"""Processes that have served an episode and wait for the next one."""


def found_program(word: str, folder: Path) -> Path:
    """Return the file that a command begins with, in ``folder`` or among ours; it may not exist."""
    beside, ours = folder / word, PORTABLE / word
    return ours if ours.is_file() and not beside.exists() else beside


def end_idle() -> None:
    """End the processes that wait for another episode."""
    while _IDLE:
        for connection in _IDLE.popitem()[1]:
            connection.child.close()


def remote_tracker(
    program: Program, parameters: Mapping[str, Any], rng: np.random.Generator
) -> RemoteTracker | RemoteMultiTracker | TraxTracker:
    """Return a new tracker that draws from a copy of ``rng``, in a process that waits or a new one.

    Its greeting says which protocol it speaks; one of TraX gets neither parameters nor random numbers.

    Raises:
        ProcessError: if the process does not start, or does not make the tracker, in time.
    """
    waiting = [each for each in _IDLE.get(program, ()) if each.child.is_alive]
    connection = waiting.pop() if waiting else _started(program)
    _IDLE[program] = waiting
    if isinstance(connection, TraxTracker):
        return connection
    how: dict[str, Any] = {"limit_s": program.limits.start_s}
    has = connection.call("make", dict(parameters), rng.bit_generator.state, **how)
    return RemoteMultiTracker(program, connection, has) if "start" in has else RemoteTracker(program, connection)


def _started(program: Program) -> Connection | TraxTracker:
    memory = SharedMemory()
    to_read, requests = os.pipe()
    replies, to_write = os.pipe()
    environment = {"PYTHONPATH": str(PORTABLE), **dict(program.environment)}
    environment["FRAMEOUT_PIPE"] = f"{to_read},{to_write},{memory.file}"
    try:
        child = Child(program.command, program.limits, environment, (to_read, to_write, memory.file))
    except BaseException:
        os.close(requests)
        os.close(replies)
        raise
    finally:
        os.close(to_read)
        os.close(to_write)

    def greeted(file: int, said: bytearray) -> int | None:
        return whole(file, said) if file == replies else trax.whole(file, said)

    child.take_ends(os.fdopen(requests, "wb", 0), os.fdopen(replies, "rb", 0))
    try:
        of, greeting = child.exchange(b"", -1, greeted, program.limits.start_s, [replies, child.stdout])
        if of == child.stdout:
            return TraxTracker(child, greeting)
        return Connection(child, greeting, requests, replies, memory)
    except BaseException:
        child.kill()
        raise


class _Remote:
    """What trackers of one target and of many have in common.

    Attributes:
        elsewhere_cpu_s: see ``OutsourcingTracker``.
    """

    def __init__(self, program: Program, connection: Connection) -> None:
        self._program, self._connection = program, connection

    @property
    def elsewhere_cpu_s(self) -> float:
        """CPU time of the process and all that it has started, for the latest answer."""
        return self._connection.elsewhere_cpu_s

    def release(self, whole: bool) -> int:
        """Keep the process for the next episode if all went well (``whole``), else end it.

        Returns:
            the number of processes that it has started and left alone; then it is ended too.
        """
        child = self._connection.child
        left = len(child.strays())
        if whole and not left and child.is_alive:
            _IDLE.setdefault(self._program, []).append(self._connection)
        else:
            child.kill()
        return left


class RemoteTracker(_Remote):
    """See ``trackers.protocols.Tracker``."""

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        self._connection.call("initialise", observation, box_xyxy)

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        estimate: Estimate = self._connection.call("update", observation)
        return estimate


class RemoteMultiTracker(_Remote):
    """See ``trackers.protocols.MultiTracker``; it has the further methods and attributes that the tracker has."""

    def __init__(self, program: Program, connection: Connection, has: Sequence[str]) -> None:
        super().__init__(program, connection)
        if "survey" in has:
            self.survey = self._survey
        if "revised" in has:
            self.revised = self._revised
        if "gap_method" in has:
            self.gap_method = RemoteGapMethod(connection, connection.call("keep", "gap_method"))
        if "decides_at" in has:
            self.decides_at = connection.call("decides_at")

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._connection.call("start", background, camera)

    def update(self, observation: Observation) -> Sequence[Track]:
        """See ``MultiTracker``."""
        tracks: Sequence[Track] = self._connection.call("update", observation)
        return tracks

    def _survey(self, site: SiteSurvey) -> None:
        self._connection.call("survey", site)

    def _revised(self) -> Sequence[Sequence[Track]]:
        answers: Sequence[Sequence[Track]] = self._connection.call("revised")
        return answers


class RemoteGapMethod:
    """See ``trackers.gaps.GapMethod``: an object in the process, which is dropped there when this one is."""

    def __init__(self, connection: Connection, of: int) -> None:
        self._connection, self._of = connection, of
        weakref.finalize(self, connection.drop, of)

    def __deepcopy__(self, memo: dict[int, Any]) -> RemoteGapMethod:
        return RemoteGapMethod(self._connection, self._connection.call("copy", of=self._of))

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""
        self._connection.call("learn", pieces, of=self._of)

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        bridge: Bridge | None = self._connection.call("extrapolate", past, count, around, of=self._of)
        return bridge

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        bridge: Bridge | None = self._connection.call("interpolate", past, future, around, of=self._of)
        return bridge
