"""Runs of frames on which a flag is true."""

from __future__ import annotations

from collections.abc import Iterable, Iterator


def runs(flags: Iterable[bool]) -> Iterator[tuple[int, int]]:
    """Yield first frame and end (the frame after the last) of every maximal run of true ``flags``."""
    first = None
    frame = -1
    for frame, flag in enumerate(flags):
        if flag and first is None:
            first = frame
        elif not flag and first is not None:
            yield first, frame
            first = None
    if first is not None:
        yield first, frame + 1
