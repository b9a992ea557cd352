"""Occlusions, changes of light and nearby people: the events of the suite ``stereo``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from benchmarks.contract.suite import EventTest, EventWords
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges.stereo.metrics.people_events import LIGHT_KINDS, NEAR, NOBODY_NEAR, OCCLUSION


def _is(kind: str) -> EventTest:
    return lambda event: bool(event["kind"] == kind)


def _describe(events: Sequence[dict[str, Any]]) -> str:
    lengths = [event["length_frames"] for event in events if event["kind"] == OCCLUSION]
    lights = Counter(event["kind"] for event in events if event["light"])
    hidden = counted(len(lengths), "occlusion")
    changes = counted(lights.total(), "change of light", "changes of light")
    if lengths:
        hidden += f" of {lengths_text(lengths)}"
    if lights:
        changes += f" ({', '.join(f'{lights[kind]} × {kind}' for kind in LIGHT_KINDS if kind in lights)})"
    return f"{hidden}, {changes}"


EVENTS = EventWords(
    name="events",
    key="event",
    tests={
        "occlusions": _is(OCCLUSION),
        "2 s after any change of light": lambda event: bool(event["light"]),
        **{f"2 s after {kind}": _is(kind) for kind in LIGHT_KINDS},
        NEAR: _is(NEAR),
        NOBODY_NEAR: _is(NOBODY_NEAR),
    },
    describe=_describe,
)
