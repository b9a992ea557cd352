"""Real sequences as the suite ``frame-out`` judges them: in pixels alone, by the boxes of the target.

The scores are those of simulated episodes, as far as boxes define them. A frame with a box is in view; a frame without
one is an absence, and what follows it a return. A tracker is on the target where its box and the true one have an IoU
of at least 0.5. Nothing is known of metres, of roads and of other cars. In means over sequences each one counts the
same in the scores of OTB, as there.

An absence is a frame-out of the kind ``unseen`` in rows, without a side and a turn. Metrics that are
functions of an episode are not called, since they may need metres.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.contract.judging import OnSequences, Score
from benchmarks.judges.frame_out.episode_scores import in_view_scores, recovery_scores, run_kept, silent_frames
from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.metrics.frame_outs import find_frame_outs
from benchmarks.judges.frame_out.metrics.localisation import ON_CAR_IOU, box_iou
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from scenarios.scenario import Episode

_EACH_SEQUENCE = ("centre_error_px", "precision_20_px", "success_auc", "success_curve")
"""Scores of OTB."""


class SequenceJudge(FrameOutJudge):
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, sequence: Episode) -> None:
        super().__init__(sequence, None)

    def scores(self, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
        """Return the scores of one tracker, by boxes alone."""
        known = replace(
            self.truth,
            visible_fraction=np.where(self.truth.state == "out", 0.0, np.nan),
            side=np.full_like(self.truth.side, ""),
            on_road=None,
            turning=None,
            longest_frames=None,
        )
        return score_sequence(known, estimate, failed_at_frame)


def score_sequence(truth: TruthSeries, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
    """Return all scores of one tracker in one sequence.

    Args:
        failed_at_frame: see ``episode_scores.score_episode``.
    """
    on_target = box_iou(estimate.box_xyxy, truth.box_xyxy[:, truth.target]) >= ON_CAR_IOU
    scores: list[Score] = []
    for absence in find_frame_outs(truth):
        scores += recovery_scores(absence, on_target, None, round(truth.rate_hz), closed_loop=False)
    scores += [
        replace(score, weight=1.0) if score.metric in _EACH_SEQUENCE else score
        for score in in_view_scores(truth, estimate, on_target, failed_at_frame)
    ]
    return [*scores, run_kept(scores), silent_frames(estimate)]


ON_SEQUENCES = OnSequences(
    judge=SequenceJudge,
    headline=(
        "success_auc",
        "precision_20_px",
        "centre_error_px",
        "f_measure",
        "in_view_gm",
        "recovery_rate",
        "kept_rate",
        "frames_per_s",
    ),
    silence="no overlap, and as far off as the picture is wide and high",
    compared=("success_auc", "precision_20_px", "f_measure", "in_view_gm", "recovery_rate", "kept_rate"),
)
