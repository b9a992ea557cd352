"""The suite ``frame-out``: where is the car while it is outside the picture, and is it found again?"""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.contract.suite import Metric, Scene, Suite, register_suite
from benchmarks.contract.tuning_episodes import TuningEpisodes
from benchmarks.judges import in_view, view_time
from benchmarks.judges.frame_out.episode_scores import NEES_CAP, added_scores, errors_while_out, offscreen_scores
from benchmarks.judges.frame_out.events import EVENTS
from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.metrics import localisation, offscreen, posterior, single_object
from benchmarks.judges.frame_out.metrics.frame_outs import FrameOut
from benchmarks.judges.frame_out.real import ON_SEQUENCES
from benchmarks.judges.frame_out.references import ORACLES
from benchmarks.judges.frame_out.row_meanings import ROW_MEANINGS
from benchmarks.judges.recovery import Recovery, judge_recovery, time_scores
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.judges.view_time import LOSSES_PER_MINUTE, TIME_IN_VIEW, TIME_SEEN
from benchmarks.statistics import long_term


def _rate(name: str, summary: str, row: str = "", kind: str | None = None) -> Metric:
    return Metric(name, summary, "fraction", "higher", (row or name,), kind=kind)


def _coverage(share: float) -> Metric:
    words = f"frames outside whose truth lies in the posterior's {100 * share:g} % region ({share:g} is right)"
    return Metric(f"coverage_{100 * share:g}", words, "fraction", "higher", ideal=share)


def _error(name: str, summary: str, unit: str = "m") -> Metric:
    return Metric(name, summary, unit, "lower")


def _errors_outside() -> Iterator[Metric]:
    """Yield mean and median of the errors outside, of all frame-outs and of those at whose exit the car was had."""
    of_all = {
        "offscreen_error": "error on all frames outside",
        "offscreen_error_30": "error 30 frames after the exit, of frame-outs that last longer",
        "offscreen_error_100": "error 100 frames after the exit, of frame-outs that last longer",
    }
    for ending, condition in (("", ""), ("_if_had", ", where the tracker had the car at the exit")):
        for name, summary in of_all.items():
            row = f"{name}{ending}_m"
            yield _error(row, summary + condition)
            words = f"median over frame-outs of the {'mean ' if name == 'offscreen_error' else ''}{summary}{condition}"
            yield Metric(f"{name}{ending}_median_m", words, "m", "lower", (row,), "median")


_OUTSIDE = tuple(f"offscreen_error{frames}{ending}_m" for ending in ("", "_if_had") for frames in ("", "_30", "_100"))
"""Rows of errors outside."""
_CURVES = ("precision_curve", "recall_curve")

FRAME_OUT = Suite(
    name="frame-out",
    edition=2,
    summary="a car seen from a helicopter: where is it while outside the picture, and is it found again?",
    scenes=(Scene("road-town", tuned_on=TuningEpisodes(seeds=range(300, 308), fresh=16)),),
    preset="standard",
    quick_preset="quick",
    judge=FrameOutJudge,
    metrics=(
        _rate("recovery_rate", "frame-outs after which the tracker is on the car within 5 frames", "recovered"),
        _rate("road_recovery_rate", "the same, of frame-outs on the road", "recovered", "road"),
        _rate("excursion_recovery_rate", "the same, of those with a way off the road", "recovered", "excursion"),
        _rate("turn_recovery_rate", "the same, of those with a turn at a crossing", "recovered", "turned"),
        _rate(
            "long_recovery_rate",
            "the same, of those longer than any that the preset draws",
            "recovered",
            "long",
        ),
        _rate("kept_rate", "frame-outs recovered and still on the car one second later", "kept"),
        _rate("road_kept_rate", "the same, of frame-outs on the road", "kept", "road"),
        _rate("excursion_kept_rate", "the same, of those with a way off the road", "kept", "excursion"),
        _rate("kept_run_rate", "episodes with all judged frame-outs kept", "run_kept"),
        Metric(
            "wrong_car_rate",
            "frame-outs after which the tracker is locked on another car",
            "fraction",
            "lower",
            ("locked_on_wrong_car",),
        ),
        Metric(
            "time_to_recover_frames",
            "mean time from back in full to on the car, never = 60 (Kaplan-Meier, restricted)",
            "frames",
            "lower",
            ("recovery_frames", "watched_frames"),
            "restricted mean",
        ),
        _rate("had_rate", "frame-outs at whose exit the tracker had the car", "had"),
        *_errors_outside(),
        Metric(
            "long_offscreen_error_m",
            "error on all frames of frame-outs that are longer than any that the preset draws",
            "m",
            "lower",
            ("offscreen_error_m",),
            kind="long",
        ),
        _error("offscreen_error_car_lengths", "error on all frames outside, in lengths of the car", "car lengths"),
        _error("reentry_error_m", "error on the last frame outside"),
        *(_coverage(share) for share in (0.5, 0.9, 0.95)),
        Metric(
            "nees",
            f"normalised error squared of the posterior outside, of a frame at most {NEES_CAP:g} (2 is right)",
            "1",
            "lower",
            ideal=2.0,
        ),
        _rate("in_view_tpr", "frames in view on which the tracker says so and is on the car"),
        _rate("in_view_tnr", "frames out of view on which the tracker says so"),
        in_view.IN_VIEW_GM,
        Metric("precision", "VOT-LT precision", "fraction", "higher", _CURVES, "precision"),
        Metric("recall", "VOT-LT recall", "fraction", "higher", _CURVES, "recall"),
        Metric(
            "f_measure",
            "VOT-LT F-score, at the confidence that makes it greatest",
            "fraction",
            "higher",
            _CURVES,
            "f",
        ),
        _error("centre_error_px", "centre error on frames in view", "px"),
        _rate("precision_20_px", "frames in view with a centre error of at most 20 px (OTB)"),
        _rate("success_auc", "area under the success curve (OTB)"),
        TIME_SEEN,
        TIME_IN_VIEW,
        LOSSES_PER_MINUTE,
        *SPEED,
    ),
    headline=(
        "recovery_rate",
        "kept_rate",
        "time_seen",
        "offscreen_error_30_m",
        "offscreen_error_30_median_m",
        "offscreen_error_30_if_had_m",
        "coverage_95",
        "in_view_gm",
        "f_measure",
        "frames_per_s",
    ),
    compared=(
        "recovery_rate",
        "kept_rate",
        "excursion_recovery_rate",
        "offscreen_error_30_m",
        "offscreen_error_100_m",
        "in_view_gm",
        "f_measure",
    ),
    tuned_for={"kept_rate": 1.0, "f_measure": 1.0, "offscreen_error_m": -0.01},
    events=EVENTS,
    silence=f"the worst error, {offscreen.WORST_ERROR_M:g} m",
    references=ORACLES,
    on_sequences=ON_SEQUENCES,
    definitions={
        FrameOut: ("recovered", "kept", "locked_on_wrong_car", "run_kept", "recovery_frames", "watched_frames"),
        Recovery: ("recovered", "kept", "locked_on_wrong_car", "run_kept", "recovery_frames", "watched_frames"),
        judge_recovery: ("recovered", "kept", "locked_on_wrong_car", "run_kept"),
        time_scores: ("recovery_frames", "watched_frames"),
        localisation.on_object: ("recovered", "kept", "locked_on_wrong_car", "had", "in_view_tpr"),
        offscreen.ground_error_m: (
            *_OUTSIDE,
            "offscreen_error_car_lengths",
            "reentry_error_m",
        ),
        errors_while_out: ("had", *_OUTSIDE, "reentry_error_m"),
        offscreen_scores: ("offscreen_error_car_lengths", "coverage_50", "coverage_90", "coverage_95", "nees"),
        posterior.Calibration: ("coverage_50", "coverage_90", "coverage_95", "nees"),
        posterior.coverage: ("coverage_50", "coverage_90", "coverage_95"),
        in_view.present_and_absent: ("in_view_tpr", "in_view_tnr", "centre_error_px", "precision_20_px", "success_auc"),
        in_view.true_positive_rate: ("in_view_tpr",),
        in_view.true_negative_rate: ("in_view_tnr",),
        long_term.precision_recall_curves: ("precision_curve", "recall_curve"),
        single_object.centre_error_px: ("centre_error_px",),
        single_object.precision_20_px: ("precision_20_px",),
        single_object.success_curve: ("success_auc",),
        single_object.success_auc: ("success_auc",),
        view_time: ("time_seen", "time_in_view", "losses_per_minute"),
        view_time.losses_per_minute: ("losses_per_minute",),
    },
    row_meanings=ROW_MEANINGS,
    added=added_scores,
)
register_suite(FRAME_OUT)
