"""The channels of a stored frame: one value a pixel, coded without loss unless JPEG is chosen; and how each looks."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import blosc2
import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import Frame, Scenario
from scenarios.truth import Meaning, meanings
from sim.checks import check

COUNTS = "counts"
PICTURES = ("image_rgb", "right_rgb", COUNTS)
"""Fields of ``Observation`` that hold a value a pixel."""
NORMALS = "normal_world"
"""Unit vectors (H, W, 3) float32 of the visible surfaces; 0 where there is none."""
LOSSY, JPEG_QUALITY = "jpeg", 95
Rgb = NDArray[np.uint8]

EMPTY = (28, 30, 35)
"""Colour of pixels without a value."""
_SHARES = (1.0, 99.0)
"""Percentiles at the ends of a scale."""
_LOG_FROM = 8.0
"""Ratio of its ends from which on a scale is logarithmic."""
_GOLDEN = 0.618034
"""Steps of this size about the circle of hues keep neighbouring numbers apart."""

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
        extension: of a file with them.
        encode: returns the bytes of an array (H, W, …). decode: returns the array of the bytes.
    """

    extension: str
    encode: Callable[[NDArray[Any]], bytes]
    decode: Callable[[bytes], NDArray[Any]]


def _pack(array: NDArray[Any]) -> bytes:
    parameters = _FLOATS if array.dtype.kind == "f" else _INTEGERS if array.itemsize > 1 else _BYTES
    packed: bytes = blosc2.asarray(np.ascontiguousarray(array), cparams=parameters, contiguous=True).to_cframe()
    return packed


def _encode_image(extension: str, parameters: tuple[int, int], array: NDArray[Any]) -> bytes:
    swapped = cv2.cvtColor(array, cv2.COLOR_RGB2BGR) if array.ndim == 3 else array
    return cv2.imencode(extension, swapped, parameters)[1].tobytes()


def _read_image(coded: bytes) -> NDArray[Any]:
    read = cv2.imdecode(np.frombuffer(coded, np.uint8), cv2.IMREAD_UNCHANGED)
    check("picture", read is not None, "a PNG or JPEG file", f"{len(coded)} bytes that are none")
    assert read is not None
    return cv2.cvtColor(read, cv2.COLOR_BGR2RGB) if read.ndim == 3 else read


_encode_png = partial(_encode_image, ".png", (cv2.IMWRITE_PNG_COMPRESSION, 1))


def _encode_jpeg(array: NDArray[Any], quality: int = JPEG_QUALITY) -> bytes:
    return _encode_image(".jpg", (cv2.IMWRITE_JPEG_QUALITY, quality), array)


CODINGS: dict[str, Coding] = {
    "blosc2": Coding("b2nd", _pack, lambda packed: blosc2.ndarray_from_cframe(packed)[:]),
    "png": Coding("png", _encode_png, _read_image),
    LOSSY: Coding("jpg", _encode_jpeg, _read_image),
}
"""By name. ``blosc2``: Zstandard or LZ4 after shuffling, for any values; the others for pictures (``PICTURES``)."""


def channels_of(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of all channels that a scenario's frames may have, in the order in which they are stored."""
    maps = (name for name, meaning in meanings(scenario.truth).items() if meaning.per_pixel)
    return (*PICTURES, *maps, NORMALS)


def check_pictures(pictures: str) -> None:
    """Raise ValueError unless ``pictures`` names a coding, or is ``jpeg-QUALITY``."""
    _quality_of(pictures)


def coding_of(channel: str, pictures: str) -> str:
    """Return the name of a channel's coding, where pictures have the coding ``pictures``. Counts are never lossy."""
    coding = LOSSY if pictures.startswith(LOSSY) else pictures
    is_coded_so = channel in PICTURES and not (channel == COUNTS and coding == LOSSY)
    return coding if is_coded_so else "blosc2"


def encoded(channel: str, pictures: str, value: NDArray[Any]) -> bytes:
    """Return the bytes of a channel's values, where pictures have the coding ``pictures``."""
    coding = coding_of(channel, pictures)
    return _encode_jpeg(value, _quality_of(pictures)) if coding == LOSSY else CODINGS[coding].encode(value)


def _quality_of(pictures: str) -> int:
    """Return the quality of JPEG in the name of a coding, ``JPEG_QUALITY`` if it says none."""
    match = re.fullmatch(rf"{LOSSY}-(\d+)", pictures)
    good = pictures in CODINGS or (match is not None and 1 <= int(match[1]) <= 100)
    check("pictures", good, f"one of {', '.join(CODINGS)}, {LOSSY}-1 to {LOSSY}-100", repr(pictures))
    return JPEG_QUALITY if match is None else int(match[1])


def value_of(frame: Frame, channel: str, normals: Callable[[], NDArray[np.float32]]) -> NDArray[Any] | None:
    """Return a frame's values of a channel; None if it has none, such as a right picture that was lost."""
    if channel == NORMALS:
        return normals()
    found: NDArray[Any] | None = getattr(frame.observation if channel in PICTURES else frame.truth, channel)
    return None if found is None or found.size == 0 else found


def channel_picture(
    channel: str, value: NDArray[Any], meaning: Meaning | None, instance_id: NDArray[np.int64]
) -> tuple[Rgb, str]:
    """Return a channel's values (H, W, …) as a picture (H, W, 3), and the range of its values in words.

    Colours follow from the values' type, shape and meaning alone.

    Args:
        meaning: None for the channels that are no field of truth.
        instance_id: (N,) of the objects; in maps of ids all else is pale.
    """
    if value.ndim == 3 and value.dtype == np.uint8:
        return np.ascontiguousarray(value), ""
    if channel == NORMALS or (value.ndim == 3 and value.shape[2] == 3):
        return _directions(value), ""
    if value.ndim == 3:
        return _motions(value, "" if meaning is None else meaning.unit)
    if meaning is None:
        low, high = np.percentile(value, _SHARES)
        grey = np.clip((value - low) * (255.0 / max(high - low, 1e-12)), 0, 255).astype(np.uint8)
        return np.repeat(grey[..., None], 3, axis=2), f"{low:,.0f} to {high:,.0f}"
    if meaning.unit == "class":
        return _identities(value, np.arange(256)), ""
    if meaning.unit in ("id", "word"):
        return _identities(value, instance_id), ""
    return _scale(value.astype(np.float64), meaning.unit)


def _scale(value: NDArray[np.float64], unit: str) -> tuple[Rgb, str]:
    known = np.isfinite(value)
    if not known.any():
        return _painted(np.zeros((*value.shape, 3), np.uint8), known), "no values"
    low, high = np.percentile(value[known], _SHARES)
    clipped, log = np.clip(np.where(known, value, low), low, high), low > 0 and high / low >= _LOG_FROM
    shares = np.log(clipped / low) / np.log(high / low) if log else (clipped - low) / max(high - low, 1e-12)
    image = cv2.applyColorMap((255 * shares).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    sign = "" if unit == "1" else f" {unit}"
    return _painted(image, known), f"{low:.3g} to {high:.3g}{sign}{', log' if log else ''}"


def _identities(value: NDArray[Any], instance_id: NDArray[np.int64]) -> Rgb:
    ids, places = np.unique(value, return_inverse=True)
    objects = np.sort(instance_id)
    of_object = np.isin(ids, objects)
    # Objects count from 0, so that ids in equal steps do not fall on neighbouring hues.
    number = np.where(of_object, np.searchsorted(objects, ids), ids).astype(np.float64)
    pale = 0.25 + 0.25 * (number * _GOLDEN**2 % 1.0)
    hue_deg = 360.0 * (number * _GOLDEN % 1.0)
    colours = _of_hsv(hue_deg, np.where(of_object, 0.75, 0.10), np.where(of_object, 0.95, pale))
    return colours[places.reshape(value.shape)]


def _directions(value: NDArray[Any]) -> Rgb:
    known = np.isfinite(value).all(axis=2) & (value != 0).any(axis=2)
    return _painted(np.clip(127.5 * (np.nan_to_num(value) + 1.0), 0, 255).astype(np.uint8), known)


def _motions(value: NDArray[Any], unit: str) -> tuple[Rgb, str]:
    """Hue is the direction of the first two components, saturation their length."""
    known = np.isfinite(value).all(axis=2)
    x, y = np.moveaxis(np.where(known[..., None], value, 0.0)[..., :2].astype(np.float64), 2, 0)
    length = np.hypot(x, y)
    longest = max(float(np.percentile(length[known], _SHARES[1])) if known.any() else 0.0, 1e-9)
    image = _of_hsv(np.degrees(np.arctan2(y, x)) % 360.0, np.clip(length / longest, 0.0, 1.0), 0.95)
    return _painted(image, known), f"0 to {longest:.3g} {unit}"


def _of_hsv(hue_deg: NDArray[np.float64], saturation: Any, value: Any) -> Rgb:
    """Return colours (…, 3) of hues (…), saturations and values of 0 to 1."""
    hsv = np.stack(np.broadcast_arrays(hue_deg, saturation, value), axis=-1).astype(np.float32)
    coloured = cv2.cvtColor(hsv.reshape(1, -1, 3), cv2.COLOR_HSV2RGB).reshape(hsv.shape)
    return np.rint(255 * coloured).astype(np.uint8)


def _painted(image: NDArray[Any], known: NDArray[np.bool_]) -> Rgb:
    painted: Rgb = np.where(known[..., None], image, np.array(EMPTY, np.uint8)).astype(np.uint8)
    return painted
