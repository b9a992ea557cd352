"""Frame rates, as files tell them or as times imply them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.checks import check


def rate_of(time_s: NDArray[np.float64]) -> float | None:
    """Return the frames per second of times (T,) of successive frames; None if they do not tell."""
    step_s = np.diff(time_s)
    step_s = step_s[np.isfinite(step_s) & (step_s > 0)]
    return float(1.0 / np.median(step_s)) if len(step_s) else None


def rate_of_rows(frames: NDArray[np.int64], time_s: NDArray[np.float64]) -> float | None:
    """Return the frames per second of the rows (R,) of a file, which may leave out frames or name them several times.

    None if the times do not tell.
    """
    known = np.isfinite(time_s)
    at, first = np.unique(frames[known], return_index=True)
    if len(at) == 0:
        return None
    return rate_of(np.interp(np.arange(at[0], at[-1] + 1), at, time_s[known][first]))


def rate_told(name: str, rate_hz: Any) -> float | None:
    """Return the rate that a file tells; None if it tells none, or 0 as for a video that the program could not read.

    Raises:
        ValueError: for what is no number; it names the file ``name``.
    """
    if rate_hz is None:
        return None
    number = isinstance(rate_hz, (int, float, np.number)) and not isinstance(rate_hz, bool)
    check(name, number, "a number of frames_per_second", repr(rate_hz))
    return float(rate_hz) if 0 < rate_hz < np.inf else None


def rate_in(name: str, attributes: bytes) -> float | None:
    """Return the rate in idtracker.ai's attributes, an object in JSON. Raises ValueError as ``rate_told`` does."""
    try:
        told: Any = json.loads(attributes)
    except ValueError as error:
        raise ValueError(f"{name}: expected an object in JSON, got something else: {error}") from None
    check(name, isinstance(told, dict), "an object in JSON", f"a {type(told).__name__}")
    return rate_told(name, told.get("frames_per_second"))
