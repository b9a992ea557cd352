"""Real sequences as the suite ``frame-out`` judges them: in pixels alone, by the boxes of the target.

The scores are those of simulated episodes, as far as boxes define them. A frame with a box is in view; a frame without
one is an absence, and what follows it a return. A tracker is on the target where its box and the true one have an IoU
of at least 0.5. Nothing is known of metres, of roads and of other cars. In means over sequences each one counts the
same in the scores of OTB, as there.

An absence is a frame-out of the kind ``unseen`` in rows, without a side and a turn. Functions that ``episode_score``
adds are not called, since they may need metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, OnSequences, Score
from benchmarks.judges.frame_out.episode_scores import in_view_scores, recovery_scores, run_kept, silent_frames
from benchmarks.judges.frame_out.metrics import localisation
from benchmarks.judges.frame_out.metrics.frame_outs import find_absences
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries, estimated_box
from scenarios.scenario import Episode, Frame
from trackers.types import CameraCommand, Estimate

_EACH_SEQUENCE = ("centre_error_px", "precision_20_px", "success_auc", "success_curve")
"""Scores of OTB."""


class SequenceJudge:
    """See ``benchmarks.contract.judging.Judge``. The truth has one object."""

    def __init__(self, sequence: Episode) -> None:
        self.rate_hz, camera = sequence.rate_hz, sequence.start.camera
        self._size_px = (camera.width_px, camera.height_px)
        self._box_xyxy: list[NDArray[np.float64]] = []
        self._state: list[str] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self._box_xyxy.append(frame.truth.box_xyxy)
        self._state.append(str(frame.truth.state[0]))

    def sheet(self) -> SequenceSheet:
        """See ``Judge``."""
        return SequenceSheet(self)

    @property
    def first_box_xyxy(self) -> NDArray[np.float64]:
        """Box of the target (4,) in the first picture."""
        return self._box_xyxy[0][0]

    @property
    def truth(self) -> TruthSeries:
        """Truth of the whole sequence; NaN in metres, and false where nothing is known of roads."""
        box_xyxy, state = np.array(self._box_xyxy), np.array(self._state)
        frames = len(state)
        return TruthSeries(
            rate_hz=self.rate_hz,
            size_px=self._size_px,
            target=0,
            ground_m=np.full((frames, 1, 2), np.nan),
            object_size_m=np.full((1, 3), np.nan),
            position_px=0.5 * (box_xyxy[..., :2] + box_xyxy[..., 2:]),
            box_xyxy=box_xyxy,
            visible_fraction=np.where(state == "out", 0.0, np.nan),
            state=state,
            side=np.full(frames, ""),
            on_road=np.zeros(frames, dtype=bool),
            turning=np.zeros(frames, dtype=bool),
        )


class SequenceSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``."""

    def __init__(self, judge: SequenceJudge) -> None:
        self._judge = judge
        self._position_px: list[NDArray[np.float64]] = []
        self._box_xyxy: list[NDArray[np.float64]] = []
        self._in_view_probability: list[float] = []

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``."""
        probability = estimate.in_view_probability
        self._position_px.append(np.array(estimate.position_px, dtype=float))
        self._box_xyxy.append(estimated_box(estimate, self._judge.first_box_xyxy).copy())
        self._in_view_probability.append(float("nan") if probability is None else float(probability))

    def scores(self, ending: Ending) -> Sequence[Score]:
        """See ``ScoreSheet``."""
        unknown = np.full(len(self._position_px), np.nan)
        estimate = EstimateSeries(
            position_px=np.array(self._position_px),
            position_m=np.stack([unknown, unknown], axis=1),
            box_xyxy=np.array(self._box_xyxy),
            in_view_probability=np.array(self._in_view_probability),
            has_posterior=np.zeros(len(unknown), dtype=bool),
            credible_level=unknown,
            nees=unknown,
        )
        return score_sequence(self._judge.truth, estimate, ending.failed_at_frame)


def score_sequence(truth: TruthSeries, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
    """Return all scores of one tracker in one sequence.

    Args:
        failed_at_frame: see ``episode_scores.score_episode``.
    """
    on_target = localisation.on_target(truth, estimate)
    scores: list[Score] = []
    for absence in find_absences(truth.state):
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
