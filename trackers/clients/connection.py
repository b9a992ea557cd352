"""The runner's side of the protocol that ``frameout_client.py`` speaks: trackers in processes of their own, version 1.

The environment variable ``FRAMEOUT_PIPE`` holds three numbers of files, with commas between them: requests to read,
replies to write, and shared memory to map. Standard input, output and error are no part of it.

A message is ``HEAD``, two little-endian 64-bit numbers of bytes, then as many bytes of JSON in UTF-8, and as many of
arrays. The arrays of a request lie in the shared memory instead, in as many bytes from its start, and the tracker
copies what it needs before it replies. In the JSON an object has its class under ``is``, an ``array`` its element type
``of`` as NumPy writes it (``<f8``), ``shape``, ``strides`` in bytes, and the place ``at`` of its lowest byte among the
arrays; one without ``is``, or a ``dict``, is a table. Floats have all their digits; ``NaN`` and ``Infinity`` are
written so. Fields have the names of ``trackers.types`` and ``trackers.gaps``.

The tracker's first message is its greeting: ``frameout`` (the version), ``name``, ``pid``. Then each request has
``number``, ``call``, ``of`` (an object, 0 is the tracker), ``with`` (a list) and ``drop`` (objects that are not called
again), and each reply the same ``number`` and either ``answer`` with ``elsewhere_cpu_s``, see
``OutsourcingTracker``, or ``error``, a line, with ``at``, a list of places in the code, each a file and a line:

===========  ==================================  ===================================================================
call         with                                answer
===========  ==================================  ===================================================================
make         parameters, state of the generator  which of ``start survey revised gap_method decides_at`` the new tracker
                                                 has; it takes the place of the one before
initialise   Observation, box_xyxy               null
survey       SiteSurvey                          null
start        Observations, CameraModel           null
update       Observation                         an Estimate, or Tracks if the tracker has ``start``
revised                                          a list of lists of Tracks
decides_at                                       a number
keep         ``"gap_method"``                    number of the object that the tracker offers
copy                                             number of a copy of the object ``of``
learn        Pieces                              null; this and the next two are calls of a gap method
extrapolate  Piece, count, Surroundings          a Bridge or null
interpolate  Piece, Piece, Surroundings          a Bridge or null
===========  ==================================  ===================================================================

The end of the requests is the end of the process.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import mmap
import os
import sys
import tempfile
import weakref
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.clients.child import LONGEST_ANSWER, Child, ProcessError
from trackers.clients.portable.frameout_client import HEAD, VERSION, decode, encode
from trackers.gaps import Bridge
from trackers.types import Estimate, Track

_ANSWERS: Mapping[str, type] = {each.__name__: each for each in (Estimate, Track, Bridge)}
_ALIGNED = 64
_KEPT_BYTES = 1 << 26
"""Shared memory beyond this, e.g. for many pictures of a background, is given back after the request."""


class SharedMemory:
    """Memory without a name that a child process maps by its ``file``; what was put before is overwritten.

    Attributes:
        file: its number. used: bytes of the arrays since ``clear``.
    """

    def __init__(self) -> None:
        self.file = os.memfd_create("frameout") if sys.platform == "linux" else _unnamed()
        self.used = 0
        self._mapped: mmap.mmap | None = None
        self._size = 0
        weakref.finalize(self, os.close, self.file)

    def put(self, array: NDArray[Any], before: int, size: int) -> int:
        """Store an array and return its place, see ``frameout_client.encode``."""
        at = -(-self.used // _ALIGNED) * _ALIGNED
        self.used = at + size
        if self.used > self._size:
            self._size = max(self.used, 2 * self._size)
            os.ftruncate(self.file, self._size)
            self._mapped = mmap.mmap(self.file, self._size)
        if size:
            np.ndarray(array.shape, array.dtype, self._mapped, at + before, array.strides)[...] = array
        return at

    def clear(self) -> None:
        """Forget what is in it."""
        self.used = 0
        if self._size > _KEPT_BYTES:
            self._mapped, self._size = None, 0
            os.ftruncate(self.file, 0)


def _unnamed() -> int:
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


class Connection:
    """A child process that speaks the protocol. After any failure it is ended, and every further call fails.

    Attributes:
        name: of its tracker, as it greets.
        elsewhere_cpu_s: see ``OutsourcingTracker``; of the latest call.
    """

    def __init__(self, child: Child, greeting: bytes, requests: int, replies: int, memory: SharedMemory) -> None:
        """``child`` has said ``greeting`` in the file ``replies``. Raises ProcessError for another version."""
        self.child, self.elsewhere_cpu_s = child, 0.0
        self._requests, self._replies, self._memory = requests, replies, memory
        self._numbers = itertools.count(1)
        self._unused: list[int] = []
        hello = _read(greeting)
        if (version := hello.get("frameout")) != VERSION:
            wanted = f"expected version {VERSION} of the protocol, as frameout_client.py of this Frameout speaks"
            raise ProcessError(f"{wanted} it, got {version!r}")
        self.name = str(hello.get("name"))

    def call(self, call: str, *arguments: Any, of: int = 0, limit_s: float | None = None) -> Any:
        """Return the answer to a call, see the module's docstring. Raises ProcessError."""
        number = next(self._numbers)
        try:
            self._memory.clear()
            # It may be longer at the end of this line: objects are dropped at any time.
            unused = [self._unused.pop() for _ in range(len(self._unused))]
            content = {"number": number, "call": call, "of": of, "with": arguments, "drop": unused}
            text = json.dumps(encode(content, self._memory.put)).encode()
            request = HEAD.pack(len(text), self._memory.used) + text
            limit_s = self.child.limits.frame_s if limit_s is None else limit_s
            _, reply = self.child.exchange(request, self._requests, whole, limit_s, [self._replies])
            read = _read(reply)
            if read.get("number") != number:
                raise ProcessError(f"expected the reply to request {number}, got one to {read.get('number')!r}")
            if "error" in read:
                line = next(iter(str(read["error"]).splitlines()), "an error without a word")
                raise ProcessError(f"{line}{_places(read.get('at'))}")
            elsewhere_cpu_s = _seconds("elsewhere_cpu_s", read.get("elsewhere_cpu_s") or 0.0)
        except BaseException:
            self.child.kill()
            raise
        self.elsewhere_cpu_s = max(self.child.spent_cpu_s, elsewhere_cpu_s)
        return read.get("answer")

    def drop(self, of: int) -> None:
        """Have the next call drop an object."""
        self._unused.append(of)


def whole(file: int, said: bytearray) -> int | None:
    """Return the length of the message that bytes begin with, if it is whole. Raises ProcessError for no message."""
    if len(said) < HEAD.size:
        return None
    length = HEAD.size + sum(HEAD.unpack_from(said))
    if length > LONGEST_ANSWER:
        raise ProcessError(f"expected a message of the protocol, got {bytes(said[:40])!r}")
    return length if len(said) >= length else None


def _read(message: bytes) -> dict[str, Any]:
    size, _ = HEAD.unpack_from(message)
    body = memoryview(message)[HEAD.size + size :]
    try:
        read = decode(json.loads(message[HEAD.size : HEAD.size + size]), body, _answer_class)
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        broken = f"{type(error).__name__}: {error}"
        raise ProcessError(f"expected a message of the protocol, got one that is broken: {broken}") from None
    if not isinstance(read, dict):
        raise ProcessError(f"expected a message of the protocol, got {read!r:.60}")
    return read


def _seconds(name: str, value: Any) -> float:
    with contextlib.suppress(TypeError, ValueError):
        if 0.0 <= float(value) < np.inf:
            return float(value)
    raise ProcessError(f"{name}: expected a time in seconds, got {value!r:.60}")


def _places(at: object) -> str:
    """Return in words where an error came from, as a reply has it; none of what is no list of files and lines."""
    places = [each for each in at if isinstance(each, tuple) and len(each) == 2] if isinstance(at, tuple) else []
    return "".join(f" ({Path(str(file)).name}, line {line})" for file, line in places)


def _answer_class(name: str, fields: str) -> Callable[..., Any]:
    if name not in _ANSWERS:
        raise ValueError(f"expected an answer of {', '.join(_ANSWERS)}, got a {name}")
    # A later client may know fields that this one does not.
    return lambda **given: _ANSWERS[name](**{field: value for field, value in given.items() if value is not None})
