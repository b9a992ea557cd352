"""Written answers on a sequence, judged as those of a tracker are."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.contract.judging import Ending, Score
from benchmarks.data.sequences import BoxedSequence, SequenceEpisode
from benchmarks.judges.frame_out.real import SequenceJudge
from trackers.types import Estimate


def all_scores_of(sequence: BoxedSequence, answer: Callable[[int], Estimate]) -> list[Score]:
    """Return all scores of the answer on each frame."""
    episode = SequenceEpisode(sequence)
    judge = SequenceJudge(episode)
    sheet = judge.sheet()
    for k in range(episode.frame_count):
        frame = episode.step()
        judge.see(frame, None)
        sheet.keep(frame, answer(k))
    return list(sheet.scores(Ending()))
