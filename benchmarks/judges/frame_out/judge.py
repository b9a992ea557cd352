"""The judge of the suite ``frame-out``: arrays of truth and estimates over the frames, scored at the end.

The column ``frame_out`` holds the attributes of a frame-out::

    {"index": 0, "exit_frame": 57, "length_frames": 43, "back_frame": 104 or null,
     "kind": "road"|"excursion"|"outside"|"unseen", "side": "left"|"right"|"top"|"bottom",
     "turned": true if it turned at a crossing while outside}

``back_frame`` is the first frame on which the whole car is in the picture again;
null if it left again, or the episode ended, before that. ``length_frames`` counts
frames wholly outside.

Rows about one frame-out:

=================================  =====================================================================
``recovered``                      1 if on the car within 5 frames after ``back_frame``, else 0
``kept``                           1 if recovered and still on the car one second later, else 0
``recovery_frames``                frames from ``back_frame`` to the first one on the car; null = never
``watched_frames``                 frames from ``back_frame`` to the next exit or the episode's end: where
                                   ``recovery_frames`` is null the time to recover is censored here. Both are
                                   given of every frame-out with a ``back_frame``
``locked_on_wrong_car``            1 if on one other vehicle, not the target, in most of the frames
                                   ``back_frame`` … ``back_frame + 5``
``reentry_error_m``                error on the last frame wholly outside
``had``                            1 if on the car at the exit: on the last frame before it or the first outside
``offscreen_error_m``              mean error outside, weighted by the number of frames
``offscreen_error_30_m``, ``_100_m``  error 30 / 100 frames after the exit (only if it lasts that long)
``offscreen_error_if_had_m`` …     the same three again, only if the tracker had the car at the exit
``offscreen_error_by_frame_m``     *series*: error on each frame outside; entry k is k frames after the exit
=================================  =====================================================================

``recovered``, ``kept`` and ``locked_on_wrong_car`` exist for the same frame-outs, chosen by the truth alone: those
with at least 5 frames and one second of the episode after ``back_frame``. (In closed loop the tracker steers: there
``exit_frame`` counts, and a car that never returns is not recovered.)

Rows about the whole episode: ``coverage_50/90/95`` and ``nees`` (frames outside; null for a
tracker without a posterior in the episode; for others a frame without one is a miss, with the capped NEES),
``credible_level_histogram`` (*series* of 20: share of outside frames whose truth lay at level 0-5 %, 5-10 % … of the
posterior; flat = calibrated), ``offscreen_error_car_lengths``, ``in_view_tpr``, ``in_view_tnr``, ``precision_curve``
and ``recall_curve`` (*series* over ``statistics.long_term.THRESHOLDS``), ``centre_error_px``, ``precision_20_px``,
``success_auc``, ``success_curve`` (*series* over ``metrics.localisation.THRESHOLDS``), ``precision_plot`` (*series*
over ``metrics.localisation.CENTRE_ERRORS_PX``, only drawn), ``time_seen``, ``time_in_view`` and ``losses_per_minute``
(closed loop only, see ``judges.view_time``), ``run_kept`` (1 if every frame-out that can be judged was kept),
``silent_frames``, the times (see ``judges.tracker_speed.times``), ``failed_at_frame`` (only if the tracker failed),
``frames``. For real sequences see ``frame_out.real``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score
from benchmarks.contract.metric import Metric
from benchmarks.contract.sequence_truth import SequenceTruth
from benchmarks.judges.frame_out.episode_scores import precision_plot, score_episode
from benchmarks.judges.frame_out.metrics.posterior import NO_POSTERIOR, calibration
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from benchmarks.judges.masks import MaskScores
from benchmarks.judges.view_time import view_scores
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.truth import RoadTruth
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.truth import Truth, without_pixels
from scenarios.visibility import is_in_view
from sim.optics import intersect_plane
from trackers.types import CameraCommand, Estimate


class FrameOutJudge:
    """See ``benchmarks.contract.judging.Judge``.

    Attributes:
        functions: metrics whose ``value`` is a function of the truth and a tracker's estimates.
    """

    functions: tuple[Metric, ...] = ()

    def __init__(self, episode: Episode, scenario: Scenario | None) -> None:
        """``scenario`` is None for a real sequence, whose one object is the target."""
        assert episode.start.box_xyxy is not None
        self.rate_hz, self.first_box_xyxy = episode.rate_hz, episode.start.box_xyxy
        self._camera, self._scenario, self._closed_loop = episode.start.camera, scenario, episode.closed_loop
        preset = None if episode.closed_loop else getattr(episode, "preset", None)
        self._longest_frames = preset.frame_outs.frames[1] if isinstance(preset, RoadTown) else None
        self._truths: list[Truth] = []
        self._in_view: list[bool] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self._truths.append(without_pixels(frame.truth))
        if self._closed_loop:
            widest_view_m = np.inf if self._scenario is None else self._scenario.widest_view_m
            self._in_view.append(is_in_view(frame.truth, self.target, frame.camera, widest_view_m))

    def sheet(self) -> FrameOutSheet:
        """See ``Judge``."""
        return FrameOutSheet(self)

    @cached_property
    def target(self) -> int:
        """Index of the target among the objects."""
        return 0 if self._scenario is None else self._truths[0].index_of(self._scenario.target)

    @cached_property
    def truth(self) -> TruthSeries:
        """Truth of the whole episode; the number of objects is constant."""

        def stacked(name: str) -> NDArray[Any]:
            return np.array([getattr(truth, name) for truth in self._truths])

        has_roads = isinstance(self._truths[0], RoadTruth)
        return TruthSeries(
            rate_hz=self.rate_hz,
            size_px=(self._camera.width_px, self._camera.height_px),
            target=self.target,
            ground_m=stacked("T_world_object")[:, :, :2, 3],
            object_size_m=self._truths[0].size_m,
            position_px=stacked("position_px"),
            box_xyxy=stacked("box_xyxy"),
            visible_fraction=stacked("visible_fraction")[:, self.target],
            state=stacked("state")[:, self.target],
            side=stacked("side")[:, self.target],
            on_road=stacked("on_road") if has_roads else None,
            turning=stacked("turning") if has_roads else None,
            outside=stacked("outside")[:, 0] if isinstance(self._truths[0], SequenceTruth) else None,
            longest_frames=self._longest_frames,
        )

    def scores(self, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
        """Return the scores of one tracker."""
        scores = score_episode(self.truth, estimate, failed_at_frame, closed_loop=self._closed_loop)
        scores += [Score(metric.name, metric.value_of(self.truth, estimate)) for metric in self.functions]
        if self._closed_loop:
            scores += view_scores(np.array(self._in_view), self.truth.visible_fraction, self.rate_hz)
        return scores

    def drawn(self, estimate: EstimateSeries) -> Iterator[Score]:
        """Yield what is only drawn of one tracker: no metric is made of it, and no edition stands for it."""
        yield from precision_plot(self.truth, estimate)


class FrameOutSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``. Posteriors are judged at once, to free particles."""

    def __init__(self, judge: FrameOutJudge) -> None:
        self._judge = judge
        self._kept: list[tuple[Any, ...]] = []
        self._masks = MaskScores()

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``."""
        truth, target = frame.truth, self._judge.target
        height_m = float(truth.T_world_object[target, 2, 3] + 0.5 * truth.size_m[target, 2])
        position_px = np.array(estimate.position_px, dtype=float)
        box_xyxy, probability = estimate.box_xyxy, estimate.in_view_probability
        has_box = box_xyxy is not None
        if box_xyxy is None:
            half_px = 0.5 * (self._judge.first_box_xyxy[2:] - self._judge.first_box_xyxy[:2])
            box_xyxy = np.concatenate([position_px - half_px, position_px + half_px])
        outside = truth.state[target] == "out"
        self._masks.keep(truth, target, estimate)
        self._kept.append(
            (
                position_px,
                intersect_plane(frame.camera, truth.T_world_camera, position_px, height_m),
                np.array(box_xyxy, dtype=float),
                float("nan") if probability is None else float(probability),
                estimate.particles_px is not None or estimate.covariance_px is not None,
                *(calibration(estimate, truth, target, frame.camera) if outside else NO_POSTERIOR),
                has_box,
            )
        )

    def scores(self, ending: Ending) -> Sequence[Score]:
        """See ``ScoreSheet``."""
        estimate = EstimateSeries(*map(np.array, zip(*self._kept, strict=True)))
        scores = self._judge.scores(estimate, ending.failed_at_frame)
        return [*scores, *self._masks.scores(), *self._judge.drawn(estimate)]
