"""Losses, the events of suite ``follow``: a description of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.contract.suite import EventWords
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges.view_time import LOSS_S


def _describe(losses: Sequence[dict[str, Any]]) -> str:
    if not losses:
        return f"no losses: the target was never out of view for longer than {LOSS_S:g} s"
    lengths = [each["length_frames"] for each in losses]
    never = sum(each["back_frame"] is None for each in losses)
    return f"{counted(len(losses), 'loss', 'losses')} of {lengths_text(lengths)}, {never} of them to the end"


EVENTS = EventWords(
    name="losses",
    key="event",
    # Losses depend on the controller, so trackers are compared over whole episodes only.
    tests={},
    describe=_describe,
)
