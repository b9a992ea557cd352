"""The judge of the suite ``frame-out``: arrays of truth and estimates over the frames, scored at the end."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.judges.frame_out.episode_scores import score_episode
from benchmarks.judges.frame_out.metrics import posterior
from benchmarks.judges.frame_out.metrics.series import (
    EstimateSeries,
    TruthSeries,
    estimated_box,
    truth_series,
)
from benchmarks.judges.view_time import view_scores
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.truth import RoadTruth
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.truth import without_pixels
from scenarios.visibility import is_in_view
from sim.optics import intersect_plane
from trackers.types import CameraCommand, CameraModel, Estimate


class FrameOutJudge:
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self._rate_hz, self._closed_loop = episode.rate_hz, episode.closed_loop
        self._target = scenario.target
        preset = getattr(episode, "preset", None)
        self._longest_frames: int | None = None
        if isinstance(preset, RoadTown) and not episode.closed_loop:
            self._longest_frames = preset.frame_outs.frames[1]
        box_xyxy = episode.start.box_xyxy
        assert box_xyxy is not None
        self._first_box_xyxy = box_xyxy
        self._truths: list[RoadTruth] = []
        self._in_view: list[bool] = []
        self._camera: CameraModel | None = None

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self._truths.append(without_pixels(truth_as(frame.truth, RoadTruth)))
        self._in_view.append(is_in_view(frame.truth, self.target, frame.camera))
        self._camera = frame.observation.camera

    def sheet(self) -> FrameOutSheet:
        """See ``Judge``."""
        return FrameOutSheet(self, self._first_box_xyxy)

    @cached_property
    def target(self) -> int:
        """Index of the target among the objects."""
        return self._truths[0].index_of(self._target)

    @cached_property
    def truth(self) -> TruthSeries:
        """Truth of the whole episode."""
        assert self._camera is not None
        return truth_series(self._truths, self.target, self._rate_hz, self._camera, self._longest_frames)

    def scores(self, estimate: EstimateSeries, failed_at_frame: int | None) -> list[Score]:
        """Return the scores of one tracker."""
        scores = score_episode(self.truth, estimate, failed_at_frame, closed_loop=self._closed_loop)
        if self._closed_loop:
            scores += view_scores(np.array(self._in_view), self.truth.visible_fraction, self._rate_hz)
        return scores


class FrameOutSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``. Posteriors are judged at once, to free particles."""

    def __init__(self, judge: FrameOutJudge, first_box_xyxy: NDArray[np.float64]) -> None:
        self._judge = judge
        self._first_box_xyxy = first_box_xyxy
        self._position_px: list[NDArray[np.float64]] = []
        self._position_m: list[NDArray[np.float64]] = []
        self._box_xyxy: list[NDArray[np.float64]] = []
        self._in_view_probability: list[float] = []
        self._has_posterior: list[bool] = []
        self._calibrations: list[posterior.Calibration] = []

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``."""
        camera, truth = frame.camera, frame.truth
        target = self._judge.target
        height_m = float(truth.T_world_object[target, 2, 3] + 0.5 * truth.size_m[target, 2])
        position_px = np.array(estimate.position_px, dtype=float)
        probability = estimate.in_view_probability
        outside = truth.state[target] == "out"
        self._position_px.append(position_px)
        self._position_m.append(intersect_plane(camera, truth.T_world_camera, position_px, height_m))
        self._box_xyxy.append(estimated_box(estimate, self._first_box_xyxy).copy())
        self._in_view_probability.append(float("nan") if probability is None else float(probability))
        self._has_posterior.append(posterior.has_posterior(estimate))
        self._calibrations.append(
            posterior.calibration(estimate, truth, target, camera) if outside else posterior.NO_POSTERIOR
        )

    def scores(self, ending: Ending) -> Sequence[Score]:
        """See ``ScoreSheet``."""
        series = EstimateSeries(
            position_px=np.array(self._position_px),
            position_m=np.array(self._position_m),
            box_xyxy=np.array(self._box_xyxy),
            in_view_probability=np.array(self._in_view_probability),
            has_posterior=np.array(self._has_posterior),
            credible_level=np.array([c.credible_level for c in self._calibrations]),
            nees=np.array([c.nees for c in self._calibrations]),
        )
        return self._judge.scores(series, ending.failed_at_frame)
