"""Gaps of fish: the events of the suite ``fish``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.contract.suite import EventWords
from benchmarks.contract.text import counted, lengths_text


def _describe(events: Sequence[dict[str, Any]]) -> str:
    lengths = sorted(event["length_frames"] for event in events)
    if not lengths:
        return "no gaps"
    crossing = sum(event["crosses"] for event in events)
    return (
        f"{counted(len(lengths), 'gap')} of {lengths_text(lengths)}, half of them below "
        f"{lengths[len(lengths) // 2] + 1}; in {crossing} fish cross"
    )


EVENTS = EventWords(
    name="gaps",
    key="event",
    tests={
        "up to 10 frames": lambda event: bool(event["length_frames"] <= 10),
        "11 to 50 frames": lambda event: bool(10 < event["length_frames"] <= 50),
        "more than 50 frames": lambda event: bool(event["length_frames"] > 50),
        "fish cross": lambda event: bool(event["crosses"]),
        "no fish cross": lambda event: not event["crosses"],
        "two fish": lambda event: bool(event["fish_count"] <= 2),
        "three or more fish": lambda event: bool(event["fish_count"] > 2),
    },
    describe=_describe,
)
