"""The channels of a stored frame: one value a pixel, coded without loss unless JPEG is chosen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import blosc2
import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import Frame, Scenario
from scenarios.truth import meanings
from sim.checks import check

COUNTS = "counts"
PICTURES = ("image_rgb", "right_rgb", COUNTS)
"""Fields of ``Observation`` that hold a value a pixel."""
NORMALS = "normal_world"
"""Unit vectors (H, W, 3) float32 of the visible surfaces; 0 where there is none."""
JPEG_QUALITY = 95

_ZSTD, _LZ4 = blosc2.Codec.ZSTD, blosc2.Codec.LZ4
_BYTES, _INTEGERS, _FLOATS = (
    blosc2.CParams(codec=codec, clevel=1, nthreads=1, filters=[each], filters_meta=[0])
    for codec, each in (
        (_ZSTD, blosc2.Filter.BITSHUFFLE),
        (_ZSTD, blosc2.Filter.SHUFFLE),
        # On a frame's floats, most of whose bits are as good as random, Zstandard takes twice as long for a sixth less.
        (_LZ4, blosc2.Filter.SHUFFLE),
    )
)


@dataclass(frozen=True)
class Coding:
    """One way to write the values of a picture as bytes.

    Attributes:
        extension: of a file with them. is_lossless: whether reading returns the same values.
        encode: returns the bytes of an array (H, W, …). decode: returns the array of the bytes.
    """

    extension: str
    is_lossless: bool
    encode: Callable[[NDArray[Any]], bytes]
    decode: Callable[[bytes], NDArray[Any]]


def _pack(array: NDArray[Any]) -> bytes:
    parameters = _FLOATS if array.dtype.kind == "f" else _INTEGERS if array.itemsize > 1 else _BYTES
    packed: bytes = blosc2.asarray(np.ascontiguousarray(array), cparams=parameters, contiguous=True).to_cframe()
    return packed


def _unpack(packed: bytes) -> NDArray[Any]:
    array: NDArray[Any] = blosc2.ndarray_from_cframe(packed)[:]
    return array


def _image_encoder(extension: str, *parameters: int) -> Callable[[NDArray[Any]], bytes]:
    def encode(array: NDArray[Any]) -> bytes:
        swapped = cv2.cvtColor(array, cv2.COLOR_RGB2BGR) if array.ndim == 3 else array
        return cv2.imencode(extension, swapped, parameters)[1].tobytes()

    return encode


def _read_image(coded: bytes) -> NDArray[Any]:
    read = cv2.imdecode(np.frombuffer(coded, np.uint8), cv2.IMREAD_UNCHANGED)
    check("picture", read is not None, "a PNG or JPEG file", f"{len(coded)} bytes that are none")
    assert read is not None
    return cv2.cvtColor(read, cv2.COLOR_BGR2RGB) if read.ndim == 3 else read


CODINGS: dict[str, Coding] = {
    "blosc2": Coding("b2nd", True, _pack, _unpack),
    "png": Coding("png", True, _image_encoder(".png", cv2.IMWRITE_PNG_COMPRESSION, 1), _read_image),
    "jpeg": Coding("jpg", False, _image_encoder(".jpg", cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY), _read_image),
}
"""By name. ``blosc2``: Zstandard or LZ4 after shuffling, for any values; the others for pictures (``PICTURES``)."""


def channels_of(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of all channels that a scenario's frames may have, in the order in which they are stored."""
    maps = (name for name, meaning in meanings(scenario.truth).items() if meaning.per_pixel)
    return (*PICTURES, *maps, NORMALS)


def coding_of(channel: str, pictures: str) -> str:
    """Return the name of a channel's coding, where pictures have the coding ``pictures``. Counts are never lossy."""
    if channel not in PICTURES or (channel == COUNTS and not CODINGS[pictures].is_lossless):
        return "blosc2"
    return pictures


def value_of(frame: Frame, channel: str, normals: Callable[[], NDArray[np.float32]]) -> NDArray[Any] | None:
    """Return a frame's values of a channel; None if it has none, such as a right picture that was lost."""
    if channel == NORMALS:
        return normals()
    found: NDArray[Any] | None = getattr(frame.observation if channel in PICTURES else frame.truth, channel)
    return None if found is None or found.size == 0 else found
