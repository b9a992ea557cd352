"""The folder protocol of VOTS: a program gets a whole sequence at once as files, and leaves its answers as files.

It runs in a folder with ``frames_color.txt``, the path of a picture in each line, and ``query_obj0.txt``: the number of
the picture that the target is shown in, 0, and in the second line its box. It ends with exit status 0 and leaves
``output_obj0.txt``, a region for each picture, 0 for none, and if it has them ``output_obj0_confidence.txt``, a number
for each. Regions are those of ``trackers.regions``. Source: ``vot/tracker/folder.py`` of the VOT toolkit 0.9.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.clients.child import LONGEST_ANSWER, Child, Limits, ProcessError
from trackers.regions import Rectangle, estimate_of, read_confidence, read_region
from trackers.types import Estimate

_TARGET = "obj0"


def answers_on(
    command: Sequence[str],
    environment: dict[str, str],
    limits: Limits,
    pictures: Iterable[NDArray[np.uint8]],
    first_box_xyxy: Callable[[], NDArray[np.float64]],
) -> tuple[list[Estimate], float]:
    """Return a program's estimates on all pictures (H, W, 3), and its CPU time a picture in seconds.

    Args:
        limits: of one picture, but for memory; it starts in ``start_s``.
        first_box_xyxy: returns the box (4,) of the target in the first picture; called after the pictures are read.

    Raises:
        ProcessError: if it fails, takes too long or leaves other files.
    """

    sizes: list[tuple[int, ...]] = []

    def fill(folder: Path) -> None:
        (folder / "pictures").mkdir()
        with (folder / "frames_color.txt").open("w") as names:
            for picture in pictures:
                file = folder / "pictures" / f"{len(sizes):08d}.png"
                cv2.imwrite(str(file), picture[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
                print(file, file=names)
                sizes.append(picture.shape[:2])
        (folder / f"query_{_TARGET}.txt").write_text(f"0\n{Rectangle(first_box_xyxy())}\n")

    child = Child(command, limits, environment, fill=fill)
    try:
        child.limits = replace(limits, frame_cpu_s=limits.start_s + len(sizes) * limits.frame_cpu_s)
        child.wait(limits.start_s + len(sizes) * limits.frame_s)
        return _read(child.folder, sizes), child.spent_cpu_s / len(sizes)
    finally:
        child.kill()


def _read(folder: Path, sizes: Sequence[tuple[int, ...]]) -> list[Estimate]:
    """Return the estimates on pictures of these heights and widths."""
    regions = _lines(folder / f"output_{_TARGET}.txt", len(sizes))
    confidences: list[float | None] = [None] * len(sizes)
    if (file := folder / f"output_{_TARGET}_confidence.txt").is_file():
        confidences = [read_confidence(line) for line in _lines(file, len(sizes))]
    estimates = []
    for k, (text, confidence, size) in enumerate(zip(regions, confidences, sizes, strict=True)):
        try:
            estimate = estimate_of(read_region(text), *size)
        except ValueError as error:
            raise ProcessError(f"output_{_TARGET}.txt, line {k + 1}: {error}") from None
        estimates.append(replace(estimate, in_view_probability=confidence))
    return estimates


def _lines(file: Path, count: int) -> list[str]:
    if not file.is_file():  # A pipe has no end.
        raise ProcessError(f"expected a file {file.name} at its end, got none")
    if (size := file.stat().st_size) > LONGEST_ANSWER:
        raise ProcessError(f"{file.name}: expected at most {LONGEST_ANSWER:,} bytes, got {size:,}")
    lines = file.read_text(errors="replace").splitlines()
    if len(lines) != count:
        raise ProcessError(f"{file.name}: expected a line for each of {count} pictures, got {len(lines)}")
    return lines
