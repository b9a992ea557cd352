"""All scores of one tracker in one episode of the suite ``frame-out``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges import in_view, recovery
from benchmarks.judges.frame_out.metrics import localisation, posterior
from benchmarks.judges.frame_out.metrics.frame_outs import FrameOut, find_frame_outs
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from benchmarks.statistics import long_term
from trackers.kernels.boxes import box_iou

NEES_CAP = 100.0
"""Largest NEES of a frame in a mean, so that single frames on which a tracker is lost do not dominate it; also the NEES
of a frame without a posterior, of a tracker that gives posteriors."""


def score_episode(
    truth: TruthSeries, estimate: EstimateSeries, failed_at_frame: int | None, closed_loop: bool
) -> list[Score]:
    """Return all scores of one tracker in one episode.

    Args:
        failed_at_frame: first frame of a failure, None without one; from there on every frame has the worst score,
            in-view detection included.
    """
    on_target = localisation.on_object(truth, estimate)[:, truth.target]
    on_other = localisation.on_other(truth, estimate)
    error_m = localisation.ground_error_m(truth, estimate)
    scores: list[Score] = []
    for frame_out in find_frame_outs(truth):
        scores += recovery_scores(frame_out, on_target, on_other, round(truth.rate_hz), closed_loop=closed_loop)
        scores += errors_while_out(frame_out, error_m, on_target)
    scores += offscreen_scores(truth, estimate, error_m)
    scores += in_view_scores(truth, estimate, on_target, failed_at_frame)
    return [*scores, run_kept(scores), silent_frames(estimate)]


def recovery_scores(
    frame_out: FrameOut,
    on_target: NDArray[np.bool_],
    on_other: NDArray[np.int64] | None,
    one_second: int,
    *,
    closed_loop: bool,
) -> Iterator[Score]:
    """Yield the scores of the recovery from one frame-out; ``on_other`` is None where no other car is known."""
    others = np.full(len(on_target), -1) if on_other is None else on_other
    judged = recovery.judge_recovery(frame_out, on_target, others, kept_frames=one_second, closed_loop=closed_loop)
    if judged is not None:
        yield Score("recovered", float(judged.recovered), event=frame_out)
        yield Score("kept", float(judged.kept), event=frame_out)
        if on_other is not None:
            yield Score("locked_on_wrong_car", float(judged.locked_on_other), event=frame_out)
    yield from recovery.time_scores(frame_out, on_target, closed_loop=closed_loop)


def run_kept(scores: Sequence[Score]) -> Score:
    """Return whether all frame-outs that can be judged were kept, from their scores; null without any."""
    kept = [score.value for score in scores if score.metric == "kept"]
    return Score("run_kept", float(all(kept)) if kept else None)


def silent_frames(estimate: EstimateSeries) -> Score:
    """Return the number of frames without an answer."""
    return Score("silent_frames", float(np.isnan(estimate.position_px).any(axis=1).sum()))


def errors_while_out(
    frame_out: FrameOut, error_m: NDArray[np.float64], on_target: NDArray[np.bool_]
) -> Iterator[Score]:
    """Yield the errors outside: the mean over the frames, weighted by their number, and those 30 and 100 frames after
    the exit, if it lasts that long; and the same again, ``…_if_had_m``, if the tracker had the car at the exit.

    It had the car if its estimate was on it (``localisation.on_object``) on the last frame before the exit or on the
    first one outside: ``had``. Blind trackers and oracles, which get the true state on that frame, have it
    where they answer with it. Without this condition an error is also that of a tracker that had lost the car before.
    """
    exit_frame, frames = frame_out.exit_frame, frame_out.length_frames
    had = bool(on_target[max(exit_frame - 1, 0) : exit_frame + 1].any())
    by_frame_m = error_m[exit_frame : exit_frame + frames]
    yield Score("had", float(had), event=frame_out)
    for ending in ("_m", "_if_had_m") if had else ("_m",):
        yield Score(f"offscreen_error{ending}", float(by_frame_m.mean()), float(frames), frame_out)
        for since_exit in (30, 100):
            if frames > since_exit:
                yield Score(f"offscreen_error_{since_exit}{ending}", float(by_frame_m[since_exit]), event=frame_out)
    yield Score("reentry_error_m", float(by_frame_m[-1]), event=frame_out)
    yield Score("offscreen_error_by_frame_m", by_frame_m.tolist(), event=frame_out)


def offscreen_scores(truth: TruthSeries, estimate: EstimateSeries, error_m: NDArray[np.float64]) -> Iterator[Score]:
    """Yield calibration, and the error in lengths of the car, on the frames on which the target is ``out``, weighted by
    their number.

    A tracker that gives a posterior on any frame of the episode has missed on frames without one: no region holds the
    truth, and its NEES is ``NEES_CAP``, also the most that any frame counts. Without a posterior in the episode,
    coverage and NEES are null; the errors are not.
    """
    out = truth.state == "out"
    frames = float(out.sum())
    if frames == 0:
        return
    car_length_m = float(truth.object_size_m[truth.target, 0])
    yield Score("offscreen_error_car_lengths", float(error_m[out].mean()) / car_length_m, frames)
    judged = bool(estimate.has_posterior.any())
    weight = frames if judged else 0.0
    level = estimate.credible_level[out]
    nees = np.minimum(np.nan_to_num(estimate.nees[out], nan=NEES_CAP), NEES_CAP)
    for percent in (50, 90, 95):
        yield Score(f"coverage_{percent}", posterior.coverage(level, percent / 100) if judged else None, weight)
    yield Score("nees", float(nees.mean()) if judged else None, weight)
    if judged:
        yield Score("credible_level_histogram", posterior.level_histogram(level).tolist(), weight)


def in_view_scores(
    truth: TruthSeries, estimate: EstimateSeries, on_target: NDArray[np.bool_], failed_at_frame: int | None
) -> Iterator[Score]:
    """Yield the scores in pixels: the target's presence, VOT-LT's curves, and OTB's scores of the frames in view."""
    present, absent = in_view.present_and_absent(truth.state, truth.visible_fraction)
    confidence = estimate.confidence(truth.size_px)
    failed = in_view.failed_frames(len(present), failed_at_frame)
    yield from in_view.oxuva_scores(present, absent, confidence >= 0.5, on_target, failed)
    iou = box_iou(estimate.box_xyxy, truth.box_xyxy[:, truth.target])
    visible = np.isin(truth.state, ("in", "partial"))
    if visible.any():
        # A position outside the picture predicts no box in it, and where nothing is known no box is right or wrong.
        counts = estimate.inside(truth.size_px) & ~failed & (truth.state != "unlabelled")
        sure = np.where(counts, confidence, 0.0)
        precision, recall = long_term.precision_recall_curves(iou, sure, visible)
        yield Score("precision_curve", precision.tolist())
        yield Score("recall_curve", recall.tolist())
    if present.any():
        weight = float(present.sum())
        error_px = localisation.centre_error_px(truth, estimate)[present]
        curve = localisation.success_curve(iou[present])
        yield Score("centre_error_px", float(error_px.mean()), weight)
        yield Score("precision_20_px", float((error_px <= localisation.PRECISION_PX).mean()), weight)
        yield Score("success_auc", float(curve.mean()), weight)
        yield Score("success_curve", curve.tolist(), weight)


def precision_plot(truth: TruthSeries, estimate: EstimateSeries) -> Iterator[Score]:
    """Yield OTB's precision plot of the frames in view, weighted by their number; nothing without one."""
    present, _ = in_view.present_and_absent(truth.state, truth.visible_fraction)
    if present.any():
        error_px = localisation.centre_error_px(truth, estimate)[present]
        yield Score("precision_plot", localisation.precision_plot(error_px).tolist(), float(present.sum()))
