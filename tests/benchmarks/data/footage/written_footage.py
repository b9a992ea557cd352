"""Small videos on disk: a red square that runs over textured ground, seen by a camera at rest or one that pans."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

WIDTH_PX, HEIGHT_PX = 160, 120
SIDE_PX = 16
FRAMES = 12
FIRST_BOX = "20,40,16,16"
_TICKS = 30_000
_GROUND = np.kron(np.random.default_rng(5).integers(40, 200, (60, 100), np.uint8), np.ones((8, 8), np.uint8))


def corner_of(frame: int) -> tuple[int, int]:
    """Return the top left corner of the square in the picture of a camera at rest."""
    return 20 + 4 * frame, 40


def picture_of(
    frame: int, pan_px: int = 0, size: tuple[int, int] = (WIDTH_PX, HEIGHT_PX), corner: tuple[int, int] | None = None
) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3); the camera looks ``pan_px`` further right with each."""
    x, y = corner_of(frame) if corner is None else corner
    ground = np.repeat(_GROUND[..., None], 3, axis=2).copy()
    ground[y : y + SIDE_PX, x : x + SIDE_PX] = (220, 20, 20)
    return np.ascontiguousarray(ground[: size[1], pan_px * frame : pan_px * frame + size[0]])


def write_video(
    path: Path,
    pictures: Sequence[NDArray[np.uint8]] | None = None,
    *,
    codec: str = "libx264",
    pixels: str = "yuv420p",
    times_s: Sequence[float] | None = None,
    options: dict[str, str] | None = None,
    **traits: object,
) -> Path:
    """Write pictures; ``traits`` are attributes of the stream's codec."""
    pictures = [picture_of(k) for k in range(FRAMES)] if pictures is None else pictures
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w", options=options or {}) as file:
        stream = file.add_stream(codec, rate=30, options={"crf": "10"} if "26" in codec else {})
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = pixels
        stream.codec_context.time_base = Fraction(1, _TICKS)
        for name, value in traits.items():
            setattr(stream.codec_context, name, value)
        for k, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = (
                round(_TICKS * (k / 30 if times_s is None else times_s[k])),
                Fraction(1, _TICKS),
            )
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
    return path


def turned(path: Path, matrix: tuple[int, int, int, int]) -> Path:
    """Write the display matrix a, b, c, d of a video's first track into its header.

    By ISO/IEC 14496-12, 8.3.2: the track header ends with nine numbers of 16.16 or 2.30 bits, in rows a b u, c d v,
    x y w, before the width and the height.
    """
    content = bytearray(path.read_bytes())
    head = content.index(b"tkhd")
    a, b, c, d = (number << 16 for number in matrix)
    struct.pack_into(">9i", content, head + 4 + 40, a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(content)
    return path


def write_sound(path: Path) -> Path:
    """Write a second of sound without pictures."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("aac", rate=44_100)
        for k in range(20):
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
            frame.sample_rate, frame.pts = 44_100, 1024 * k
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
    return path
