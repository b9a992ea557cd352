"""Pictures of a user's own footage, one after another: a video file, a folder of pictures, a camera or a stream.

Pictures are as a player shows them: rotated as the file says (the display matrix of ISO/IEC 14496-12, which phones
write), with square pixels, in 8 bits. Interlaced pictures keep their two halves, transparency is left out, and high
dynamic range is not reduced, which a note says. Nothing is kept but the latest picture and what a decoder holds.
"""

from __future__ import annotations

import re
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import USUAL_RATE_HZ
from benchmarks.contract.text import counted, printable
from benchmarks.data.pictures import ENDINGS, pictures_in
from sim.checks import check

Image: TypeAlias = NDArray[np.uint8]
_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]+://", re.IGNORECASE)
_LIVE = ("rtsp://", "rtsps://", "rtmp://", "rtp://", "udp://", "tcp://", "srt://")
_PATIENCE_S = 10.0
"""Time in which a stream must open, and send its next packet."""
_COVERS = av.stream.Disposition.attached_pic
"""Covers of music are streams of one picture."""
_HDR = {16: "PQ", 18: "HLG"}
"""Transfer characteristics of high dynamic range, by their number in ITU-T H.273."""
_FAR_OFF_S = 60.0
"""A gap between two pictures from which on their times are held for broken."""
_BROKEN = (av.FFmpegError, OSError, ValueError)
"""What FFmpeg raises of what it cannot open or decode."""
_LAST = 2**31 - 1
"""The largest number of a camera that OpenCV takes."""
_SHORT_OF = 1.5
"""Pictures that may lack at the end: what a file tells of its length is rounded."""


class Picture(NamedTuple):
    """A picture of some footage.

    Attributes:
        image_rgb: (H, W, 3).
        time_s: on the clock of the footage, seconds; greater than that of the picture before.
    """

    image_rgb: Image
    time_s: float


class Footage(ABC):
    """Footage that is open, once: its pictures are all of one size.

    Attributes:
        name: for titles, files and messages.
        rate_hz: pictures a second, on average.
        expected: number of pictures as far as it is known before they are decoded; None = unknown.
        is_live: whether it goes on without being read, so that the newest picture counts.
        notes: what a user should know of how it was read, a line each; complete after the last picture.
    """

    is_live = False

    def __init__(self, name: str, rate_hz: float, expected: int | None = None) -> None:
        self.name, self.rate_hz, self.expected = printable(name), rate_hz, expected
        self.notes: list[str] = []

    @abstractmethod
    def pictures(self) -> Iterator[Picture]:
        """Yield its pictures. What cannot be decoded ends them, with a note; before the first it raises ValueError."""

    @abstractmethod
    def close(self) -> None:
        """Let go of files and devices."""


def open_footage(source: str, rate_hz: float | None = None) -> Footage:
    """Open footage.

    Args:
        source: path of a video or of a folder of pictures, number of a camera, or address such as ``rtsp://…``.
        rate_hz: pictures a second of a folder, which does not tell; None = ``USUAL_RATE_HZ``.

    Raises:
        ValueError: if there is none that can be read.
    """
    check("video", bool(source), "a file, a folder, a camera or an address", "an empty name")
    folder = not _ADDRESS.match(source) and Path(source).is_dir()
    check("rate_hz", rate_hz is None or folder, "none but for a folder of pictures, as videos tell it", rate_hz)
    if folder:
        return PictureFolder(Path(source), USUAL_RATE_HZ if rate_hz is None else rate_hz)
    if source.isdecimal() and not Path(source).exists():
        return Live(Camera(int(source)))
    video = Video(source)
    return Live(video) if source.lower().startswith(_LIVE) else video


class Video(Footage):
    """A video file, or a stream of a network, decoded by FFmpeg."""

    def __init__(self, source: str) -> None:
        is_file = not _ADDRESS.match(source)
        # Else a colon in a file's name would be taken for a protocol.
        where = f"file:{source}" if is_file else source
        shown = Path(source).name if is_file else source
        options = {"rtsp_transport": "tcp"} if source.lower().startswith("rtsp") else {}
        try:
            self._file = av.open(where, metadata_errors="replace", timeout=_PATIENCE_S, options=options)
        except _BROKEN as error:
            raise ValueError(f"video: expected one that can be opened, got {shown!r}: {_why(error)}") from None
        # FFmpeg takes text for a picture of text.
        check("video", self._file.format.name != "tty", "one with pictures", f"{shown!r}, which is text")
        streams = [each for each in self._file.streams.video if not each.disposition & _COVERS]
        if not streams:
            kinds = ", ".join(each.type for each in self._file.streams) or "nothing"
            self._file.close()
            raise ValueError(f"video: expected a stream of pictures, got {shown!r} with {kinds}")
        self._stream = streams[0]
        rate = self._stream.average_rate or self._stream.guessed_rate
        super().__init__(shown, float(rate) if rate else USUAL_RATE_HZ)
        # A live one must not wait for later pictures.
        self._stream.thread_type = "SLICE" if source.lower().startswith(_LIVE) else "AUTO"
        self.expected = self._stream.frames or self._told_count()

    def _told_count(self) -> int | None:
        """Return the number of pictures by the length that the file tells."""
        stream, whole = self._stream, self._file.duration
        if stream.duration is not None and stream.time_base is not None:
            return round(float(stream.duration * stream.time_base) * self.rate_hz)
        return None if whole is None else round(whole / av.time_base * self.rate_hz)

    def pictures(self) -> Iterator[Picture]:
        """See ``Footage``."""
        count, last_s, first = 0, -np.inf, None
        for frame in self._frames():
            if count == 0 and (hdr := _HDR.get(int(frame.color_trc))):
                self.notes.append(f"{self.name} has high dynamic range ({hdr}): its colours are not adapted to others")
            image = _upright(self._square(frame), frame)
            first = image if first is None else first
            if image.shape != first.shape:
                sizes = f"from {_size(first)} to {_size(image)} pixels"
                self.notes.append(f"{self.name} changes {sizes} after picture {count}, and ends there")
                return
            told_s, step_s = frame.time, 1.0 / self.rate_hz
            is_next = told_s is not None and last_s < told_s < last_s + _FAR_OFF_S
            time_s = told_s if told_s is not None and (count == 0 or is_next) else max(last_s, -step_s) + step_s
            yield Picture(image, time_s)
            count, last_s = count + 1, time_s
        check("video", count > 0, "one with pictures", f"{self.name!r}, of which none can be decoded")
        if self.expected is not None and count < self.expected - _SHORT_OF:
            self.notes.append(f"{self.name} ends after {counted(count, 'picture')} of {self.expected}")

    def _frames(self) -> Iterator[av.VideoFrame]:
        """Yield what can be decoded; a note tells of the rest."""
        broken = 0
        packets = self._file.demux(self._stream)
        while True:
            try:
                packet = next(packets, None)
                if packet is None:
                    break
            except _BROKEN as error:
                self.notes.append(f"{self.name} cannot be read further: {_why(error)}")
                break
            try:
                yield from packet.decode()
            except _BROKEN:
                broken += 1
        with suppress(*_BROKEN):
            # What the decoder still holds, if the end came as an error.
            yield from self._stream.codec_context.decode(None)
        if broken:
            self.notes.append(f"{self.name} is damaged: {counted(broken, 'part')} of it cannot be decoded")

    def _square(self, frame: av.VideoFrame) -> Image:
        """Return a picture in 8 bits and three colours, with square pixels."""
        aspect = self._stream.sample_aspect_ratio
        width = round(frame.width * float(aspect)) if aspect else frame.width
        image = frame.to_ndarray(format="rgb24", width=width, height=frame.height)
        return np.asarray(image, dtype=np.uint8)

    def close(self) -> None:
        """See ``Footage``."""
        self._file.close()


def _upright(image: Image, frame: av.VideoFrame) -> Image:
    """Return a picture turned and mirrored as its display matrix says, by quarter turns.

    A point (x, y) of the stored picture is shown at ``(a x + c y, b x + d y)``, but for a shift.
    """
    held: Any = frame.side_data
    if "DISPLAYMATRIX" not in held:
        return image
    a, b, _, c, d = np.frombuffer(held["DISPLAYMATRIX"], np.int32, count=5)
    if abs(a) < abs(b):
        image, across, down = image.transpose(1, 0, 2), c, b
    else:
        across, down = a, d
    return np.ascontiguousarray(image[:: -1 if down < 0 else 1, :: -1 if across < 0 else 1])


def _size(image: Image) -> str:
    return f"{image.shape[1]} x {image.shape[0]}"


def _why(error: Exception) -> str:
    """Return the reason of an error of FFmpeg or of the system, in one line."""
    return printable(getattr(error, "strerror", None) or str(error))


class PictureFolder(Footage):
    """A folder of pictures, in order of their names; numbers in them count as such."""

    def __init__(self, folder: Path, rate_hz: float) -> None:
        check("rate_hz", 0 < rate_hz < float("inf"), "a number of pictures a second > 0", f"{rate_hz:g}")
        try:
            next(folder.iterdir(), None)
        except OSError as error:
            raise ValueError(f"video: expected a folder that can be read, got {str(folder)!r}: {_why(error)}") from None
        self._files = sorted(pictures_in(folder), key=_by_numbers)
        wanted = f"a folder with pictures ({', '.join(ENDINGS)})"
        check("video", bool(self._files), wanted, f"{str(folder)!r}, which has none")
        super().__init__(folder.resolve().name, rate_hz, len(self._files))

    def pictures(self) -> Iterator[Picture]:
        """See ``Footage``."""
        first = _decoded(self._files[0])
        name = printable(self._files[0].name)
        if first is None:
            raise ValueError(f"video: expected pictures that can be decoded, got {name!r}")
        yield Picture(first, 0.0)
        for index, file in enumerate(self._files[1:], start=1):
            image = _decoded(file)
            if image is None or image.shape != first.shape:
                wrong = "cannot be decoded" if image is None else f"is not {_size(first)} pixels, as the first one is"
                counts = f"{index} of {counted(len(self._files), 'picture')}"
                self.notes.append(f"{self.name} ends after {counts}: {printable(file.name)} {wrong}")
                return
            yield Picture(image, index / self.rate_hz)

    def close(self) -> None:
        """See ``Footage``. Nothing is open."""


def _by_numbers(file: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", file.name)]


def _decoded(file: Path) -> Image | None:
    """Return a picture (H, W, 3), turned as its EXIF says; None if it cannot be decoded."""
    try:
        content = np.frombuffer(file.read_bytes(), np.uint8)
    except OSError:
        return None
    image = cv2.imdecode(content, cv2.IMREAD_COLOR_RGB) if content.size else None
    return None if image is None else np.asarray(image, dtype=np.uint8)


class Camera(Footage):
    """A camera of this machine by its number, 0 being the first."""

    def __init__(self, number: int) -> None:
        level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        self._camera = cv2.VideoCapture(min(number, _LAST))
        cv2.utils.logging.setLogLevel(level)
        check("video", self._camera.isOpened(), "the number of a camera that opens, or a file", repr(str(number)))
        super().__init__(f"camera {number}", self._camera.get(cv2.CAP_PROP_FPS) or USUAL_RATE_HZ)

    def pictures(self) -> Iterator[Picture]:
        """See ``Footage``."""
        count = 0
        while (read := self._camera.read())[0]:
            count += 1
            yield Picture(np.asarray(cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB), np.uint8), time.monotonic())
        check("video", count > 0, "a camera that gives pictures", repr(self.name))
        self.notes.append(f"{self.name} gives no more pictures after {count}")

    def close(self) -> None:
        """See ``Footage``."""
        self._camera.release()


class Live(Footage):
    """Footage that goes on without being read: a thread reads it, and only the newest picture is handed out."""

    is_live = True

    def __init__(self, footage: Footage) -> None:
        super().__init__(footage.name, footage.rate_hz)
        self._footage = footage
        self._arrived = threading.Condition()
        self._newest: Picture | None = None
        self._error: Exception | None = None
        self._is_over, self._lost = False, 0
        self._reader = threading.Thread(target=self._read, daemon=True)

    def pictures(self) -> Iterator[Picture]:
        """See ``Footage``."""
        self._reader.start()
        while (picture := self._next()) is not None:
            yield picture
        if self._error is not None:
            raise self._error
        self.notes += self._footage.notes
        if self._lost:
            self.notes.append(
                f"{self.name}: {counted(self._lost, 'picture')} came while others were worked on: left out"
            )

    def _next(self) -> Picture | None:
        with self._arrived:
            self._arrived.wait_for(lambda: self._newest is not None or self._is_over)
            picture, self._newest = self._newest, None
        return picture

    def _read(self) -> None:
        try:
            for picture in self._footage.pictures():
                with self._arrived:
                    self._lost += self._newest is not None
                    self._newest = picture
                    self._arrived.notify()
                    if self._is_over:
                        return
        except Exception as error:  # Raised where the pictures are read.
            self._error = error
        finally:
            with self._arrived:
                self._is_over = True
                self._arrived.notify()

    def close(self) -> None:
        """See ``Footage``. The reader ends with its next picture, and may not be left with a closed file."""
        self._is_over = True
        if self._reader.ident is not None:
            self._reader.join(2.0 * _PATIENCE_S)
        self._footage.close()
