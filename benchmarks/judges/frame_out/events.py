"""Frame-outs, the events of their suite: their kinds, and a description of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from benchmarks.contract.suite import EventTest, EventWords
from benchmarks.contract.text import counted, lengths_text

_LENGTHS = (1, 16, 31, 61, 121)


def _is(name: str, value: Any) -> EventTest:
    return lambda frame_out: bool(frame_out.get(name) == value)


def _lasts(low: int, high: float) -> EventTest:
    return lambda frame_out: bool(low <= frame_out["length_frames"] < high)


def _describe(frame_outs: Sequence[dict[str, Any]]) -> str:
    if not frame_outs:
        return "no frame-outs"
    lengths = [each["length_frames"] for each in frame_outs]
    if all(each["kind"] == "unseen" for each in frame_outs):
        return f"{counted(len(frame_outs), 'absence')} of {lengths_text(lengths)}"
    turned = sum(bool(each["turned"]) for each in frame_outs)
    excursions = sum(each["kind"] == "excursion" for each in frame_outs)
    long = [each["length_frames"] for each in frame_outs if each.get("long")]
    longer = f", {len(long)} longer than drawn, with {sum(long) / sum(lengths):.0%} of all frames outside"
    return (
        f"{counted(len(frame_outs), 'frame-out')} of {lengths_text(lengths)}, "
        f"{turned} with a turn at a crossing, {excursions} with a way off the road{longer if long else ''}"
    )


EVENTS = EventWords(
    name="frame-outs",
    key="frame_out",
    tests={
        "all": lambda frame_out: True,
        "on the road": _is("kind", "road"),
        "off the road": _is("kind", "excursion"),
        "with a turn": _is("turned", True),
        "without a turn": _is("turned", False),
        "longer than drawn": _is("long", True),
        "as long as drawn": _is("long", False),
        **{f"left by the {side}": _is("side", side) for side in ("left", "right", "top", "bottom")},
        **{f"{low} to {high - 1} frames": _lasts(low, high) for low, high in pairwise(_LENGTHS)},
        f"{_LENGTHS[-1]} frames and more": _lasts(_LENGTHS[-1], float("inf")),
    },
    describe=_describe,
)
