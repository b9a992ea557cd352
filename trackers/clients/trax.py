"""The client's side of TraX, versions 1 to 4: trackers of one target as for the VOT challenge, unchanged.

Written after the protocol's specification and, where that is older than the protocol, after its reference
implementation (``docs/protocol.rst`` and ``src/trax.c`` of the project votchallenge/trax), with which
``tests/trackers/clients/test_trax.py`` compares. Messages are lines of the tracker's standard output and input; what
else it prints is no part of them::

    tracker   @@TRAX:hello "trax.version=3" "trax.image=path;memory" "trax.region=rectangle;mask"
    versions  @@TRAX:initialize "IMAGE" "REGION"         answered by a state
    1 to 3    @@TRAX:frame "IMAGE"                       answered by a state
    4         @@TRAX:initialize "REGION"
              @@TRAX:frame "IMAGE"                       answered by a state
    tracker   @@TRAX:state "REGION" "confidence=0.7"
    both      @@TRAX:quit

A picture is sent as the tracker's greeting allows: from ``memory``, as the ``path`` of a PNG file in the tracker's own
folder, or as a PNG in a ``buffer``. The box is sent as a rectangle, else as a polygon, else as a mask; regions of all
kinds are read. A ``confidence`` from 0 to 1 is the probability of being in view. Each episode has a process of its own:
a tracker that is started again may keep what it has learnt, and rows would depend on their order.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.clients.child import Child, ProcessError
from trackers.regions import Mask, Polygon, Rectangle, Region, estimate_of, read_confidence, read_region
from trackers.types import Estimate, Observation

PREFIX = b"@@TRAX:"
_VERSIONS = ("1", "2", "3", "4")
_ARGUMENT = re.compile(r'"([^"\\]*(?:\\.[^"\\]*)*)"|(\S+)', re.DOTALL)
_PROPERTY = re.compile(r"([\w.]{1,64})=(.*)", re.DOTALL)
_MASK = re.compile("^(mask:|m)")
"""Masks begin with the first on the wire, and with the second elsewhere, see ``trackers.regions``."""
_KEPT = 2
"""Pictures that stay in the folder: a tracker may read one late."""


def whole(file: int, said: bytes | bytearray) -> int | None:
    """Return the length of what a tracker has said up to the end of its first message; None if there is none yet."""
    begin = 0 if said.startswith(PREFIX) else said.find(b"\n" + PREFIX) + 1
    end = said.find(b"\n", begin) + 1
    return end if end and said.startswith(PREFIX, begin) else None


def written(name: str, *arguments: str) -> bytes:
    """Return a message as a line."""
    return PREFIX + " ".join([name, *(f'"{_escaped(each)}"' for each in arguments)]).encode() + b"\n"


def read(said: bytes) -> tuple[str, list[str], dict[str, str]]:
    """Return name, arguments and properties of the message at the end of what a tracker has said."""
    line = (b"\n" + said).rpartition(b"\n" + PREFIX)[2].decode(errors="replace").rstrip("\r\n")
    name, _, rest = line.partition(" ")
    found = [_unescaped(quoted) if quoted else plain for quoted, plain in _ARGUMENT.findall(rest)]
    properties = {match[1]: match[2] for each in found if (match := _PROPERTY.fullmatch(each))}
    return name, [each for each in found if not _PROPERTY.fullmatch(each)], properties


def _escaped(text: str) -> str:
    # Of a picture of a million letters no copy is made.
    for letter, written_as in (("\\", "\\\\"), ('"', '\\"'), ("\n", "\\n")):
        text = text.replace(letter, written_as) if letter in text else text
    return text


def _unescaped(text: str) -> str:
    return re.sub(r"\\(.)", lambda match: "\n" if match[1] == "n" else match[1], text, flags=re.DOTALL)


class TraxTracker:
    """See ``trackers.protocols.Tracker``.

    Attributes:
        elsewhere_cpu_s: see ``OutsourcingTracker``.
    """

    def __init__(self, child: Child, greeting: bytes) -> None:
        """``child`` has said ``greeting``. Raises ProcessError for what this side cannot do."""
        self._child, self.elsewhere_cpu_s = child, 0.0
        name, _, self._can = read(greeting)
        _check("greeting", name == "hello", "hello", name)
        version = self._can.get("trax.version", "1")
        _check("version", version in _VERSIONS, "1 to 4", version)
        self._version = int(version)
        self._images, self._regions = self._formats("trax.image", "path"), self._formats("trax.region", "rectangle")
        self._channels = self._formats("trax.channels", "color") if self._version > 1 else ["color"]
        _check("channels", {"color", "ir"}.issuperset(self._channels), "color or ir", ";".join(self._channels))
        self._sent = 0
        child.widen_input()

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        region = _MASK.sub("mask:", str(self._region(observation, box_xyxy)))
        if self._version < 4:
            self._ask(observation, written("initialize", *self._pictures(observation), region))
        else:
            frame = written("frame", *self._pictures(observation))
            self._ask(observation, written("initialize", region) + frame)

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        return self._ask(observation, written("frame", *self._pictures(observation)))

    def release(self, whole: bool) -> int:
        """End the process, which is told to if all went well (``whole``); return how many others it has left alone."""
        left = len(self._child.strays())
        if whole:
            self._child.close(written("quit"))
        self._child.kill()
        return left

    def _ask(self, observation: Observation, request: bytes) -> Estimate:
        """Return the estimate of the state that answers a request."""
        child = self._child
        try:
            _, said = child.exchange(request, child.stdin, whole, child.limits.frame_s, [child.stdout])
            self.elsewhere_cpu_s = child.spent_cpu_s
            name, arguments, properties = read(said)
            if name == "quit":
                raise ProcessError(f"it quit: {properties.get('trax.reason', 'no reason given')}")
            _check("message", name == "state" and len(arguments) == 1, "a state with a region", repr(said[-60:]))
            height_px, width_px = observation.image_rgb.shape[:2]
            estimate = estimate_of(read_region(_MASK.sub("m", arguments[0].strip())), height_px, width_px)
        except BaseException:
            child.kill()
            raise
        return replace(estimate, in_view_probability=read_confidence(properties.get("confidence", "")))

    def _formats(self, key: str, usual: str) -> list[str]:
        return [each for each in self._can.get(key, usual).strip().split(";") if each] or [usual]

    def _region(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> Region:
        rectangle, (x0, y0, x1, y1) = Rectangle(box_xyxy), box_xyxy
        if "rectangle" in self._regions:
            return rectangle
        if "polygon" in self._regions:
            return Polygon(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))
        _check("region", "mask" in self._regions, "rectangle, polygon or mask", ";".join(self._regions))
        return Mask(rectangle.mask(*observation.image_rgb.shape[:2]))

    def _pictures(self, observation: Observation) -> Sequence[str]:
        thermal = observation.camera.band == "thermal"
        _check("channels", "ir" not in self._channels or thermal, "color, as the camera has no other", "ir")
        return [self._picture(observation.image_rgb)] * len(self._channels)

    def _picture(self, image_rgb: NDArray[np.uint8]) -> str:
        self._sent += 1
        height_px, width_px = image_rgb.shape[:2]
        if "memory" in self._images:
            return f"image:{width_px};{height_px};rgb;{base64.b64encode(image_rgb.tobytes()).decode()}"
        _, png = cv2.imencode(".png", image_rgb[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
        if "path" in self._images:
            file = self._child.folder / f"{self._sent:08d}.png"
            file.write_bytes(png.tobytes())
            (self._child.folder / f"{self._sent - _KEPT:08d}.png").unlink(missing_ok=True)
            return f"file://{file}"
        is_buffer = "buffer" in self._images or "data" in self._images
        _check("image", is_buffer, "memory, path or buffer", ";".join(self._images))
        return f"data:image/png;{base64.b64encode(png.tobytes()).decode()}"


def _check(what: str, good: bool, expected: str, got: object) -> None:
    """Raise ProcessError for what a tracker cannot do or has not said."""
    if not good:
        raise ProcessError(f"TraX, {what}: expected {expected}, got {got}")
