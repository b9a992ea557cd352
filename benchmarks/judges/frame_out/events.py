"""Frame-outs, the events of their suite: their kinds, metrics that are compared, and a description of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from benchmarks.contract.suite import EventTest, EventWords
from benchmarks.contract.text import counted, lengths_text

_LENGTHS = (1, 16, 31, 61, 121, 1_000_000)


def _tests() -> dict[str, EventTest]:
    tests: dict[str, EventTest] = {
        "all": lambda frame_out: True,
        "on the road": lambda frame_out: frame_out["kind"] == "road",
        "off the road": lambda frame_out: frame_out["kind"] == "excursion",
        "with a turn": lambda frame_out: bool(frame_out["turned"]),
        "without a turn": lambda frame_out: frame_out["turned"] is False,
        "longer than drawn": lambda frame_out: frame_out.get("long") is True,
        "as long as drawn": lambda frame_out: frame_out.get("long") is False,
    }
    for side in ("left", "right", "top", "bottom"):
        tests[f"left by the {side}"] = _is_by(side)
    for low, high in pairwise(_LENGTHS):
        name = f"{low} to {high - 1} frames" if high < _LENGTHS[-1] else f"{low} frames and more"
        tests[name] = _lasts(low, high)
    return tests


def _is_by(side: str) -> EventTest:
    return lambda frame_out: bool(frame_out["side"] == side)


def _lasts(low: int, high: int) -> EventTest:
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
    tests=_tests(),
    describe=_describe,
)
