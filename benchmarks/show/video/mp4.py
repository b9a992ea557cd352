"""MP4 files: H.264, the same bytes for the same pictures, written atomically."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import cast

import av
import numpy as np
from numpy.typing import NDArray

from sim.checks import check


class Mp4Writer:
    """Writes pictures to ``path`` as a context manager.

    The file is written as ``.part`` and renamed at the end of the context; after an error nothing is left.
    One encoding thread and no time stamps: the same pictures make the same bytes.
    """

    def __init__(self, path: Path, rate_hz: float, *, quality: int = 20) -> None:
        """Args: ``rate_hz`` > 0 frames a second; ``quality`` 0 (lossless) to 51 (worst), x264's CRF."""
        check("rate_hz", rate_hz > 0, "a number > 0", rate_hz)
        self._path = path
        self._part = path.with_name(path.name + ".part")
        self._rate = Fraction(rate_hz).limit_denominator(1001)
        self._quality = quality
        self._size: tuple[int, int] | None = None

    def __enter__(self) -> Mp4Writer:
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._part.touch()
        except OSError as error:
            wanted = f"out: expected a file that can be written, got {str(self._path)!r}: {error.strerror}"
            raise ValueError(wanted) from None
        # The library opens the file only with the first picture.
        self._file = av.open(str(self._part), "w", format="mp4", options={"movflags": "+faststart"})
        self._file.flags |= cast(int, av.container.Flags.bitexact.value)
        self._stream = self._file.add_stream(
            "libx264",
            rate=self._rate,
            options={"crf": str(self._quality), "preset": "veryfast", "threads": "1", "tune": "animation"},
        )
        self._stream.pix_fmt = "yuv420p"
        return self

    def write(self, image_rgb: NDArray[np.uint8]) -> None:
        """Append a picture (H, W, 3). An odd last row or column is left out: yuv420p has even sizes only."""
        height, width = (side & ~1 for side in image_rgb.shape[:2])
        if self._size is None:
            self._size = (height, width)
            self._stream.width, self._stream.height = width, height
        check("image_rgb", (height, width) == self._size, f"{self._size} like the first picture", (height, width))
        picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(image_rgb[:height, :width]), format="rgb24")
        self._file.mux(self._stream.encode(picture))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            check("pictures", kind is not None or self._size is not None, "at least one", "none")
            if kind is None:
                self._file.mux(self._stream.encode())
            self._file.close()
            if kind is None:
                self._part.replace(self._path)
        finally:
            self._part.unlink(missing_ok=True)
