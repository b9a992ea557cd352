"""``opencv_csrt``: CSRT of OpenCV's contrib modules, in a child process with an environment of its own.

The contrib wheel cannot stand beside the plain one, so an interpreter of its own runs ``csrt_child.py``::

    python -m venv ~/.cache/frameout/csrt
    ~/.cache/frameout/csrt/bin/pip install opencv-contrib-python-headless==5.0.0.93 numpy==2.4.6

Another interpreter with both packages is named by the environment variable ``FRAMEOUT_CSRT_PYTHON``. Its OpenCV must
be of the version that runs here, which rows name.
"""

from __future__ import annotations

import importlib.metadata
import os
import select
import subprocess
import tempfile
import time
import weakref
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.baselines import csrt_child
from trackers.baselines.csrt_child import HELLO, REPLY, REQUEST, VERSION_BYTES
from trackers.baselines.single_target import visible_part
from trackers.kernels.boxes import box_centre, box_size
from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation

_ENDING_S = 2.0
"""Longest wait for the end of a child that has closed a stream."""


class ChildError(RuntimeError):
    """The child ended, or did not answer in time."""


class ChildPipe:
    """Sends requests to a child process and reads replies of known length.

    The child is killed and waited for by ``close``, when the pipe is dropped, and at the interpreter's exit.
    """

    def __init__(self, command: Sequence[str], limit_s: float) -> None:
        """Start ``command``.

        Args:
            limit_s: longest time of a request with its reply.

        Raises:
            OSError: if there is no such program, or on Windows, where nothing waits for a pipe in a limited time.
        """
        if not hasattr(select, "poll"):
            raise OSError(f"{command[0]}: expected Linux or macOS, for a tracker of its own process, got {os.name}")
        self._limit_s = limit_s
        with ExitStack() as files:
            # A file, since a full pipe that nobody reads would stop the child.
            self._errors = files.enter_context(tempfile.TemporaryFile())
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, bufsize=0
            )
            self._close = weakref.finalize(self, _end, self._process, files.pop_all())
        assert self._process.stdin is not None
        os.set_blocking(self._process.stdin.fileno(), False)

    @property
    def pid(self) -> int:
        """The child's process id."""
        return self._process.pid

    def ask(self, request: bytes, reply_bytes: int) -> bytes:
        """Send a request, maybe empty, and return the reply of ``reply_bytes``.

        Raises:
            ChildError: if the child ends, closes a stream or is late. The message holds its last words on stderr.

        After any exception, one of a signal's handler included, the child is closed: a reply that comes later is never
        taken for that of another request.
        """
        if not self._close.alive:
            raise ChildError("it is closed")
        with ExitStack() as failure:
            failure.callback(self.close)
            try:
                until_s = time.monotonic() + self._limit_s
                self._send(request, until_s)
                reply = self._receive(reply_bytes, until_s)
            except BrokenPipeError:
                raise ChildError(self._ending()) from None
            failure.pop_all()
        return reply

    def close(self) -> None:
        """Kill the child and wait for its end; a second call does nothing."""
        self._close()

    def _send(self, request: bytes, until_s: float) -> None:
        assert self._process.stdin is not None
        unsent = memoryview(request)
        while unsent:
            self._wait(until_s, writing=True)
            unsent = unsent[os.write(self._process.stdin.fileno(), unsent) :]

    def _receive(self, reply_bytes: int, until_s: float) -> bytes:
        assert self._process.stdout is not None
        reply = b""
        while len(reply) < reply_bytes:
            self._wait(until_s, writing=False)
            part = os.read(self._process.stdout.fileno(), reply_bytes - len(reply))
            if not part:
                raise BrokenPipeError
            reply += part
        return reply

    def _wait(self, until_s: float, *, writing: bool) -> None:
        """Wait until the child can take or has bytes."""
        stream = self._process.stdin if writing else self._process.stdout
        assert stream is not None
        waiting = select.poll()
        waiting.register(stream, select.POLLOUT if writing else select.POLLIN)
        if not waiting.poll(max(1000.0 * (until_s - time.monotonic()), 0.0)):
            raise ChildError(f"it did not answer within {self._limit_s:g} s")

    def _ending(self) -> str:
        """Return what became of a child that has closed a stream, with the last line of its stderr after a colon."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_ENDING_S)
        fate = "it closed a stream and runs on" if self._process.returncode is None else "it ended"
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        return f"{fate}: {lines[-1]}" if lines else fate


def _end(process: subprocess.Popen[bytes], files: ExitStack) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout, files):
        if stream is not None:
            stream.close()


PYTHON_VARIABLE = "FRAMEOUT_CSRT_PYTHON"
DEFAULT_FOLDER = "~/.cache/frameout/csrt"
WHEELS = (
    f"opencv-contrib-python-headless=={importlib.metadata.version('opencv-python-headless')} numpy=={np.__version__}"
)
MAKE_IT = f"python -m venv {DEFAULT_FOLDER} && {DEFAULT_FOLDER}/bin/pip install {WHEELS}"
LIMIT_S = 30.0
"""Longest time of the child for one picture, and for its start."""
_LEAST_SIDE_PX = 16
"""A smaller picture is not handed to OpenCV."""


def csrt_python() -> Path:
    """Return the interpreter that runs CSRT, which may not exist."""
    return Path(os.environ.get(PYTHON_VARIABLE) or f"{DEFAULT_FOLDER}/bin/python").expanduser()


def missing_csrt() -> str:
    """Return how to make such an interpreter if there is none, else ""; its packages are only seen when it starts."""
    return "" if csrt_python().is_file() else _how_to_make_it(str(csrt_python()))


def _how_to_make_it(got: str) -> str:
    wanted = f"{PYTHON_VARIABLE}: expected a Python with OpenCV {cv2.__version__} and its contrib modules"
    return f"{wanted}, got {got}; make one by: {MAKE_IT}"


class CsrtPipe:
    """CSRT in a child process; pictures are sent, boxes come back.

    Attributes:
        cpu_s: CPU time in seconds that the child spent on the latest picture.
    """

    def __init__(self, limit_s: float = LIMIT_S) -> None:
        """Start the child.

        Raises:
            RuntimeError: if the interpreter or a package is missing, or OpenCV is of another version than here; the
                message says how to make it.
        """
        self.cpu_s = 0.0
        python = csrt_python()
        try:
            self._pipe = ChildPipe([str(python), "-I", csrt_child.__file__], limit_s)
            _check_greeting(self._pipe)
        except (OSError, ChildError) as error:
            raise RuntimeError(_how_to_make_it(f"{python} ({error})")) from None

    def start(self, image_rgb: NDArray[np.uint8], box_xyxy: NDArray[np.float64]) -> None:
        """Start on a box (4,) in whole pixels inside a picture (H, W, 3)."""
        x, y, right, bottom = (int(value) for value in box_xyxy)
        self._ask(b"i", image_rgb, (x, y, right - x, bottom - y))

    def update(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.float64] | None:
        """Return the box (4,) in the next picture, None where CSRT fails."""
        found, x, y, width, height = self._ask(b"u", image_rgb, (0, 0, 0, 0))
        return np.array([x, y, x + width, y + height]) if found and width > 0 and height > 0 else None

    def close(self) -> None:
        """End the child; dropping the object does the same."""
        self._pipe.close()

    def _ask(self, kind: bytes, image_rgb: NDArray[np.uint8], box: tuple[int, ...]) -> tuple[float, ...]:
        height, width = image_rgb.shape[:2]
        request = REQUEST.pack(kind, width, height, *box) + image_rgb.tobytes()
        try:
            *found, self.cpu_s = REPLY.unpack(self._pipe.ask(request, REPLY.size))
        except ChildError as error:
            raise RuntimeError(f"opencv_csrt: expected a box from its child process, but {error}") from None
        return tuple(found)


def _check_greeting(pipe: ChildPipe) -> None:
    """Read the greeting. Raises ChildError, and ends the child, if it is another one or of another OpenCV."""
    hello = pipe.ask(b"", len(HELLO))
    version = pipe.ask(b"", VERSION_BYTES).decode(errors="replace").strip() if hello == HELLO else ""
    if version != cv2.__version__:
        pipe.close()
        raise ChildError(f"it has OpenCV {version}" if hello == HELLO else f"it greets by {hello!r}")


@register(
    "opencv_csrt",
    role="baseline",
    summary="OpenCV's CSRT, a general tracker; needs an environment of its own (see its docstring)",
    suites=("frame-out", "stereo"),
    missing=missing_csrt,
)
class OpenCvCsrt:
    """``cv2.TrackerCSRT`` (Lukežič et al., Discriminative correlation filter with channel and spatial reliability,
    CVPR 2017), with OpenCV's settings. It gets pictures and the first box alone.

    Its estimate is always inside the picture: where it fails, the last box stays, with an in-view probability of 0. It
    takes part in default runs where its interpreter exists; named without one, it fails with how to make
    it (module docstring).

    Attributes:
        elsewhere_cpu_s: see ``OutsourcingTracker``.
    """

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._csrt: CsrtPipe | None = None
        self.elsewhere_cpu_s = 0.0

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the part of the box that is inside the picture."""
        box_size(box_xyxy)
        camera = observation.camera
        self._box_xyxy = visible_part(box_xyxy, camera)
        if min(camera.width_px, camera.height_px) >= _LEAST_SIDE_PX:
            self._csrt = self._csrt or CsrtPipe()
            self._csrt.start(observation.image_rgb, self._box_xyxy)

    def update(self, observation: Observation) -> Estimate:
        """Return CSRT's box, or the last one where it fails; NaN if the picture is too small for it."""
        if self._csrt is None:
            return Estimate(np.full(2, np.nan))
        found = self._csrt.update(observation.image_rgb)
        self.elsewhere_cpu_s = self._csrt.cpu_s
        self._box_xyxy = self._box_xyxy if found is None else found
        return Estimate(box_centre(self._box_xyxy), self._box_xyxy.copy(), in_view_probability=float(found is not None))
