"""Ranges, conditions and sources of the rows of suite ``fish``."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from benchmarks.contract.metric import OWN, RowMeaning
from benchmarks.judges.fish.gap_scores import GAP_FRAMES
from benchmarks.judges.fish.judge import AT_ONCE
from benchmarks.judges.fish.link_scores import GROUPS
from benchmarks.judges.row_meanings import SPEED, identities

_TRUE_PLACES = "the true places of all fish, the same for all trackers"


def _tracks(ending: str, frames: str) -> Iterator[RowMeaning]:
    """Yield what holds of whole tracks and of links, of rows with this ``ending``."""
    yield from identities(frames, ending)
    yield RowMeaning((f"missed_rate{ending}",), 0, 1, frames, OWN)
    yield RowMeaning((f"false_rate{ending}",), 0, inf, frames, OWN)
    made = tuple(f"link_precision_{group}{part}{ending}" for group in GROUPS for part in ("", "_of_90"))
    share = tuple(f"link_{kind}_{group}{ending}" for group in GROUPS for kind in ("rate", "recall"))
    yield RowMeaning(made, 0, 1, "gaps of pieces of track, of the group, that are linked", OWN)
    yield RowMeaning(share, 0, 1, "gaps of pieces of track, of the group", OWN)


def _gaps(count: int) -> Iterator[RowMeaning]:
    """Yield what holds of the protocol of gaps of ``count`` frames."""
    bridged = f"gaps of {count} frames cut into true tracks, that the method bridges"
    errors = (f"gap_error_{count}_px", f"gap_interpolation_error_{count}_px")
    yield RowMeaning(errors, 0, inf, bridged, "paper C")
    coverage = (f"gap_coverage_{count}", f"gap_interpolation_coverage_{count}")
    yield RowMeaning(coverage, 0, 1, f"{bridged} with a region", OWN)
    yield RowMeaning((f"successor_rate_{count}",), 0, 1, f"fish lost together for {count} frames", OWN)


ROW_MEANINGS = (
    *_tracks("", "every frame, of the tracks as revised at the end"),
    *_tracks(AT_ONCE, "every frame, of the tracks as answered at once"),
    *(meaning for count in GAP_FRAMES for meaning in _gaps(count)),
    RowMeaning(("link_made",), 0, 1, "every gap of pieces of track", OWN),
    RowMeaning(("link_right",), 0, 1, "gaps of pieces of track that are linked", OWN),
    RowMeaning(("motion_turn",), 0, 180, _TRUE_PLACES, OWN),
    RowMeaning(("motion_heading", "motion_velocity", "motion_speed"), -1, 1, _TRUE_PLACES, OWN),
    RowMeaning(("motion_straightness", "motion_meetings"), 0, 1, _TRUE_PLACES, OWN),
    RowMeaning(tuple(f"motion_step_{each}" for each in ("p5", "p50", "p95")), 0, inf, _TRUE_PLACES, OWN),
    RowMeaning(("motion_wall_p50",), 0, inf, _TRUE_PLACES, OWN),
    SPEED,
)
