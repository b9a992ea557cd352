"""Text that is printed: numbers of tables, and names of files."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence

_SIGNS = {"fraction": "%", "1": "", "1/s": "/s", "1/min": "/min", "1/h": "/h"}
_MINUS = "\u2212"


def unit_sign(unit: str) -> str:
    """Return the sign of a unit in a table's head: ``%`` for fractions, nothing for plain numbers."""
    return _SIGNS.get(unit, unit)


def number_text(value: float | None, unit: str, *, signed: bool = False) -> str:
    """Return a number in the table's unit (fractions in per cent); an en dash for None."""
    if value is None:
        return "–"
    shown = 100.0 * value if unit == "fraction" else value
    size = abs(shown)
    digits = 1 if unit == "fraction" or 10 <= size < 100 else 0 if size >= 100 else 2
    text = f"{shown:+.{digits}f}" if signed else f"{shown:.{digits}f}"
    if float(text) == 0:
        text = text.lstrip("+-")
    return text.replace("-", _MINUS)


def interval_text(low: float | None, high: float | None, unit: str, *, signed: bool = False) -> str:
    """Return an interval as ``low … high``; empty where there is none (None or NaN)."""
    if low is None or high is None or low != low or high != high:
        return ""
    return f"{number_text(low, unit, signed=signed)} … {number_text(high, unit, signed=signed)}"


def range_text(low: float, high: float) -> str:
    """Return the range of a value in words: ``0 to 1``, ``0 to infinity``."""
    return " to ".join(f"{end:g}".replace("inf", "infinity").replace("-", _MINUS) for end in (low, high))


def counted(count: int, one: str, many: str = "") -> str:
    """Return a number of things in words: ``no losses``, ``1 loss``; ``many``: the plural, if it is not ``one`` + s."""
    return f"{count or 'no'} {one if count == 1 else many or f'{one}s'}"


def lengths_text(lengths_frames: Sequence[int]) -> str:
    """Return the least and the largest length in words: ``3 to 8 frames``, ``1 frame``."""
    low, high = min(lengths_frames), max(lengths_frames)
    return counted(high, "frame") if low == high else f"{low} to {high} frames"


def ranges_text(numbers: Iterable[int]) -> str:
    """Return whole numbers as inclusive ranges: ``0–9, 12``."""
    runs: list[list[int]] = []
    for number in sorted(set(numbers)):
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return ", ".join(f"{a:,}" if a == b else f"{a:,}–{b:,}" for a, b in runs)


def time_in_words(real_time_hz: float | None) -> str:
    """Return how trackers had time: ``in real time at 20 Hz``, or ``not in real time`` for None."""
    return "not in real time" if real_time_hz is None else f"in real time at {real_time_hz:g} Hz"


def printable(text: object) -> str:
    r"""Return text or a path with the bytes of names that are not UTF-8 as escapes, e.g. ``M\xe4nn``."""
    return os.fsencode(str(text)).decode(errors="backslashreplace")


def seed_range(text: str) -> range:
    """Return the half-open range of ``A:B``, or of one seed ``A``. Raises ValueError for anything else."""
    match = re.fullmatch(r"(\d+)(?::(\d+))?", text)
    first, end = (0, 0) if match is None else (int(match[1]), int(match[2] or int(match[1]) + 1))
    if first >= end:
        raise ValueError(f"expected A:B with 0 <= A < B, or one seed, got {text!r}")
    return range(first, end)
