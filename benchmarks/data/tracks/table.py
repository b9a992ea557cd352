"""From the rows of a file to tracks, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.printable import printable
from sim.checks import check


def from_columns(
    name: str, frames: NDArray[np.int64], animals: Sequence[str], position: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[str, ...], int]:
    """Return (T, N, 2) positions, names and first frame from one row for each animal and frame, in any order.

    Args:
        name: of the file. frames: (R,) of each row. animals: (R,) names. position: (R, 2).

    Raises:
        ValueError: if an animal has two rows of one frame, or if there is no row.
    """
    check(name, len(frames) > 0, "rows of tracks", "none")
    names, columns = np.unique(np.asarray(animals), return_inverse=True)
    first = int(frames.min())
    count = int(frames.max()) - first + 1
    check_pauses(name, frames)
    pairs = np.stack([frames, columns], axis=1)
    check(name, len(np.unique(pairs, axis=0)) == len(pairs), "each animal once on a frame", "one that is there twice")
    table = np.full((count, len(names), 2), np.nan)
    table[frames - first, columns] = position
    return table, tuple(str(each) for each in names), first


def check_pauses(name: str, frames: NDArray[np.int64]) -> None:
    """Raise ValueError if there are far more frames from the first to the last than rows (R,); no table holds those."""
    count = int(frames.max()) - int(frames.min()) + 1
    check(name, count <= 100 * len(frames) + 1000, "frames without endless pauses", f"{count} frames")


def whole_frames(name: str, frames: NDArray[Any]) -> NDArray[np.int64]:
    """Return the numbers of frames (R,) as integers. Raises ValueError for what is no whole number >= 0."""
    whole = np.isfinite(frames) & (frames == np.round(frames)) & (frames >= 0) & (frames < 2**53)
    got = ", ".join(f"{each:g}" for each in frames[~whole][:1])
    check(name, bool(whole.all()), "whole numbers >= 0 in column frame", got)
    return frames.astype(np.int64)


def reason(error: Exception) -> str:
    """Return the first line of an error's message, its kind if it has none."""
    return (str(error) or type(error).__name__).splitlines()[0]


def stem_of(path: Path) -> str:
    """Return the name of a file without its endings."""
    return printable(path.name.split(".")[0])
