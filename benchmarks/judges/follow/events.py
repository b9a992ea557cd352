"""Losses, the events of suite ``follow``: compared metrics, and a description of all losses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.contract.suite import EventWords, Metric
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges.view_time import LOSS_S, LOSSES_PER_MINUTE, TIME_IN_VIEW, TIME_SEEN

LONGEST_SEARCH_FRAMES = 150
"""Horizon of the restricted mean of the time to find the target again (10 s at 15 frames a second)."""

COMPARED = (
    TIME_SEEN,
    TIME_IN_VIEW,
    Metric(
        "centring_error",
        "distance of the target from the picture's middle, over half the diagonal, while in view",
        "fraction",
        "lower",
    ),
    LOSSES_PER_MINUTE,
    Metric(
        "time_to_find_again_s",
        f"of losses (out of view for longer than {LOSS_S:g} s): mean time from leaving view to being in view again, "
        f"never = {LONGEST_SEARCH_FRAMES} frames (Kaplan-Meier, restricted)",
        "s",
        "lower",
        ("recovery_frames", "watched_frames", "rate_hz"),
        "restricted mean",
        horizon_frames=LONGEST_SEARCH_FRAMES,
    ),
    Metric(
        "wrong_target_rate",
        "time with the estimate on another visible object, outside the target's box",
        "fraction",
        "lower",
    ),
    Metric("effort", "mean size of the obeyed commands, 1 = every axis at its limit all the time", "fraction", "lower"),
    Metric("jerkiness_per_s", "mean change of the obeyed commands in a second, in the same measure", "1", "lower"),
)
"""Metrics of whole episodes in comparisons."""


def _describe(losses: Sequence[dict[str, Any]]) -> str:
    if not losses:
        return f"no losses: the target was never out of view for longer than {LOSS_S:g} s"
    lengths = [each["length_frames"] for each in losses]
    never = sum(each["back_frame"] is None for each in losses)
    return f"{counted(len(losses), 'loss', 'losses')} of {lengths_text(lengths)}, {never} of them to the end"


EVENTS = EventWords(
    name="losses",
    key="event",
    # Losses depend on the controller, so contestants are compared over whole episodes only.
    tests={},
    compared=(),
    describe=_describe,
    episodes=COMPARED,
)
