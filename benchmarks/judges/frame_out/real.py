"""Real sequences as the suite ``frame-out`` judges them: in pixels alone, by the boxes of the target.

The scores are those of simulated episodes, as far as boxes define them. A frame with a box is in view, also where the
border cuts it or files say that a part of it is hidden: the data sets score it too. A tracker is on the target where
its box and the true one have an IoU of at least 0.5, or, if it gives a point alone, where that lies in the middle half
of the true box's width and height. Nothing is known of metres, of roads and of other cars. In means
over sequences each one counts the same in the scores of OTB, as there.

A run of frames on which the target is outside the picture, or has no box without a file that says why, is a frame-out;
it is back on the first frame with a box that the border does not cut and of which no file says that it is hidden. In
rows the frame-out is of the kind ``outside`` where files say so, else ``unseen``, without a side and a turn. Frames on
which files call the target hidden are no frame-out, as in simulated episodes, where it is behind something inside the
picture; trackers should deny its presence on them too. Frames without a label count in no score, and a frame-out is
not judged if one lies right before it or before it is over. Metrics that are functions of an episode are not called,
since they may need metres.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.contract.judging import OnSequences, Score
from benchmarks.judges.frame_out.episode_scores import (
    in_view_scores,
    precision_plot,
    recovery_scores,
    run_kept,
    silent_frames,
)
from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.metrics.frame_outs import find_frame_outs
from benchmarks.judges.frame_out.metrics.localisation import ON_CAR_IOU
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from scenarios.scenario import Episode
from trackers.kernels.boxes import box_iou

_EACH_SEQUENCE = ("centre_error_px", "precision_20_px", "success_auc", "success_curve")
"""Scores of OTB."""
_MIDDLE_HALF = 0.25
"""Farthest from the middle of a box, in its width or height."""
_ON_TARGET = "on the target: IoU of the boxes at least 0.5, or, of a point alone, in the middle half of the true box"
_BOXED = "frames with a box of the target, whole or cut by the border, seen or hidden in part"
_BACK = "frame-outs, and absences that no file explains, after which the target is back, between labelled frames"
_JUDGED = f"{_BACK}, with at least 5 frames and a second of the sequence after its return; {_ON_TARGET}"


class SequenceJudge(FrameOutJudge):
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, sequence: Episode) -> None:
        super().__init__(sequence, None)

    def scores(self, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
        """Return the scores of one tracker, by boxes alone."""
        return score_sequence(self._known, estimate, failed_at_frame)

    def drawn(self, estimate: EstimateSeries) -> Iterator[Score]:
        """See ``FrameOutJudge``."""
        for score in precision_plot(labelled(self._known), estimate):
            yield replace(score, weight=1.0)

    @property
    def _known(self) -> TruthSeries:
        truth = self.truth
        hidden = (truth.state == "occluded") & np.isnan(truth.box_xyxy[:, truth.target, 0])
        return replace(
            truth,
            visible_fraction=np.where((truth.state == "out") | hidden, 0.0, np.nan),
            side=np.full_like(truth.side, ""),
            on_road=None,
            turning=None,
            longest_frames=None,
        )


def score_sequence(truth: TruthSeries, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
    """Return all scores of one tracker in one sequence.

    Args:
        failed_at_frame: see ``episode_scores.score_episode``.
    """
    box_xyxy = truth.box_xyxy[:, truth.target]
    overlaps = box_iou(estimate.box_xyxy, box_xyxy) >= ON_CAR_IOU
    off_px = np.abs(estimate.position_px - 0.5 * (box_xyxy[:, :2] + box_xyxy[:, 2:]))
    near = (off_px <= _MIDDLE_HALF * (box_xyxy[:, 2:] - box_xyxy[:, :2])).all(axis=1)
    on_target = np.where(estimate.has_box, overlaps, near)
    scores: list[Score] = []
    for absence in find_frame_outs(truth):
        if (truth.state[max(absence.exit_frame - 1, 0) : absence.watch_end_frame] != "unlabelled").all():
            scores += recovery_scores(absence, on_target, None, round(truth.rate_hz), closed_loop=False)
    scores += [
        replace(score, weight=1.0) if score.metric in _EACH_SEQUENCE else score
        for score in in_view_scores(labelled(truth), estimate, on_target, failed_at_frame)
    ]
    return [*scores, run_kept(scores), silent_frames(estimate)]


def labelled(truth: TruthSeries) -> TruthSeries:
    """Return a truth in which a frame with a box is in view, whatever is known of it."""
    if truth.outside is None:
        return truth
    has_none = np.isnan(truth.box_xyxy[:, truth.target]).any(axis=1)
    return replace(truth, state=np.where(has_none, truth.state, "in"))


ON_SEQUENCES = OnSequences(
    judge=SequenceJudge,
    headline=(
        "success_auc",
        "precision_20_px",
        "centre_error_px",
        "f_measure",
        "in_view_gm",
        "recovery_rate",
        "time_to_recover_frames",
        "kept_rate",
        "frames_per_s",
    ),
    silence="no overlap, and as far off as the picture is wide and high",
    compared=("success_auc", "precision_20_px", "f_measure", "in_view_gm", "recovery_rate", "kept_rate"),
    conditions={
        **dict.fromkeys(("recovered", "kept"), _JUDGED),
        "run_kept": "sequences with such a frame-out",
        **dict.fromkeys(("recovery_frames", "watched_frames"), _BACK),
        "in_view_tpr": f"frames with a box of the target; {_ON_TARGET}",
        "in_view_tnr": "labelled frames without a box: the target is outside or hidden",
        "precision_curve": "labelled frames with an answer inside the picture",
        "recall_curve": _BOXED,
        **dict.fromkeys(_EACH_SEQUENCE, f"{_BOXED}; each sequence counts the same"),
    },
)
