"""Scores as a block of rows, see ``benchmarks.contract.rows``."""

from __future__ import annotations

from benchmarks.contract.judging import Score
from benchmarks.contract.rows import LAST_METRIC, Row, rounded

CONTROLLER_FAILED_AT = "controller_failed_at_frame"


def as_block(
    heading: Row,
    scores: list[tuple[int, Score]],
    controller_failed_at: int | None,
    frame_count: int,
    event_key: str,
    ending: Row,
) -> list[Row]:
    """Return the rows of a block: of the ``scores`` of each repeat, and the last ones, between ``heading`` and
    ``ending``, the columns that all of them have.
    """
    if controller_failed_at is not None:
        scores = [*scores, (0, Score(CONTROLLER_FAILED_AT, float(controller_failed_at)))]
    scores = [*scores, (0, Score(LAST_METRIC, float(frame_count)))]
    return [{**heading, **as_row(repeat, score, event_key), **ending} for repeat, score in scores]


def as_row(repeat: int, score: Score, event_key: str) -> Row:
    """Return the columns of a score."""
    return {
        "repeat": repeat,
        "metric": score.metric,
        "value": rounded(score.value),
        "weight": score.weight,
        event_key: None if score.event is None else score.event.attributes(),
    }
