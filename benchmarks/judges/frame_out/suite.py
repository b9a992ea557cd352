"""The suite ``frame-out``: where is the target while it is outside the picture, and is it found again?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf
from typing import Any

from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity
from benchmarks.contract.suite import EventTest, EventWords, Scene, Suite, TuningEpisodes, register_suite
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges import in_view
from benchmarks.judges.frame_out.episode_scores import NEES_CAP, errors_while_out, offscreen_scores
from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.metrics import localisation, posterior
from benchmarks.judges.frame_out.metrics.frame_outs import FrameOut
from benchmarks.judges.frame_out.oracle_map import ORACLES
from benchmarks.judges.frame_out.real import ON_SEQUENCES
from benchmarks.judges.frame_out.told_rows import TOLD
from benchmarks.judges.masks import MASKS
from benchmarks.judges.recovery import Recovery, judge_recovery, recovery_times
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.judges.view_time import LOSSES_PER_MINUTE, TIME_IN_VIEW, TIME_SEEN
from benchmarks.statistics import long_term
from benchmarks.statistics.pooling import BestF, BestPrecision, BestRecall, Median, RestrictedMean

_ON_TARGET = "on the target: IoU of the boxes at least 0.5, or centre within half its length on the ground"
_JUDGED = (
    "frame-outs with at least 5 frames and a second of the episode after the whole target is back; in closed loop "
    f"after it left; {_ON_TARGET}"
)
_OUT = "frames with the target wholly outside the picture"
_POSTERIOR = f"{_OUT}, of trackers that give a posterior in the episode"
_SEEN = "frames with the whole target in the picture, at least half of it seen"
_OTB = "OTB: Wu, Lim and Yang, Online object tracking: a benchmark, CVPR 2013"
_VOT_LT = "VOT-LT: Lukezic et al., Now you see me: evaluating performance in long-term visual tracking, 2018"
_NEES = "Bar-Shalom, Li and Kirubarajan, Estimation with applications to tracking and navigation, 2001; cap: Frameout"


def _quantity(name: str, conditions: str, *defined_by: Any, high: float = 1, source: str = OWN) -> Quantity:
    return Quantity(name, 0, high, conditions, source, defined_by)


_RECOVERED, _KEPT, _WRONG_CAR = (
    _quantity(name, _JUDGED, FrameOut, Recovery, judge_recovery, localisation.on_object)
    for name in ("recovered", "kept", "locked_on_wrong_car")
)
_RUN_KEPT = _quantity("run_kept", "episodes with such a frame-out", FrameOut, Recovery, judge_recovery)
_AT_EXIT = f"the last frame before each exit and the first one outside; {_ON_TARGET}"
_HAD = _quantity("had", _AT_EXIT, errors_while_out, localisation.on_object)
_CAR_LENGTHS = _quantity("offscreen_error_car_lengths", _OUT, localisation.ground_error_m, offscreen_scores, high=inf)
_NEES_OUT = _quantity("nees", _POSTERIOR, offscreen_scores, posterior.Calibration, high=NEES_CAP, source=_NEES)
_CURVES = [
    _quantity(f"{name}_curve", conditions, long_term.precision_recall_curves, source=_VOT_LT)
    for name, conditions in (
        ("precision", "frames with an answer inside the picture"),
        ("recall", "frames with the target at least partly seen"),
    )
]


def _outside(name: str, conditions: str) -> Quantity:
    return _quantity(name, conditions, localisation.ground_error_m, errors_while_out, high=localisation.WORST_ERROR_M)


_REENTRY = _outside("reentry_error_m", "the last frame of each frame-out")


def _rate(name: str, summary: str, of: Quantity, kind: str | None = None, *, better: Better = "higher") -> Metric:
    return Metric(name, summary, "fraction", better, Mean(of, kind=kind))


def _coverage(share: float) -> Metric:
    name = f"coverage_{100 * share:g}"
    words = f"frames outside whose truth lies in the posterior's {100 * share:g} % region ({share:g} is right)"
    of = _quantity(name, _POSTERIOR, offscreen_scores, posterior.Calibration, posterior.coverage)
    return Metric(name, words, "fraction", "higher", Mean(of), ideal=share)


def _errors_outside() -> Iterator[Metric]:
    """Yield mean and median of the errors outside, of all frame-outs and of those at whose exit the target was had."""
    whens = {"": ("error on all frames outside", _OUT)} | {
        f"_{n}": (
            f"error {n} frames after the exit, of frame-outs that last longer",
            f"frame-outs of more than {n} frames",
        )
        for n in (30, 100)
    }
    for ending, condition in (("", ""), ("_if_had", ", where the tracker had the target at the exit")):
        for when, (summary, frames) in whens.items():
            name, words = f"offscreen_error{when}{ending}", f"{summary}{condition}"
            of = _outside(f"{name}_m", frames + condition)
            yield Metric(of.name, words, "m", "lower", Mean(of))
            median = f"median over frame-outs of the {'' if when else 'mean '}{words}"
            yield Metric(f"{name}_median_m", median, "m", "lower", Median(of))


def _in_pictures(name: str, summary: str, defined_by: Any, unit: str = "fraction") -> Metric:
    """Return a metric of OTB; one in pixels has no cap there, and is better if lower."""
    in_px = unit == "px"
    source, high = (f"{_OTB}, there without a cap", inf) if in_px else (_OTB, 1)
    of = _quantity(name, _SEEN, in_view.present_and_absent, defined_by, high=high, source=source)
    return Metric(name, summary, unit, "lower" if in_px else "higher", Mean(of))


_LENGTHS = (1, 16, 31, 61, 121)
"""Lengths from which on a group of frame-outs begins."""


def _is(name: str, value: Any) -> EventTest:
    return lambda frame_out: bool(frame_out.get(name) == value)


def _lasts(low: int, high: float) -> EventTest:
    return lambda frame_out: bool(low <= frame_out["length_frames"] < high)


def _describe(frame_outs: Sequence[dict[str, Any]]) -> str:
    if not frame_outs:
        return "no frame-outs"
    lengths = [each["length_frames"] for each in frame_outs]
    kinds = {each["kind"] for each in frame_outs}
    if "unseen" in kinds:
        what = ("absence",) if kinds == {"unseen"} else ("frame-out or absence", "frame-outs or absences")
        return f"{counted(len(frame_outs), *what)} of {lengths_text(lengths)}"
    words = f"{counted(len(frame_outs), 'frame-out')} of {lengths_text(lengths)}"
    if kinds == {"outside"}:
        return words
    turned = sum(bool(each["turned"]) for each in frame_outs)
    excursions = sum(each["kind"] == "excursion" for each in frame_outs)
    long = [each["length_frames"] for each in frame_outs if each.get("long")]
    longer = f", {len(long)} longer than drawn, with {sum(long) / sum(lengths):.0%} of all frames outside"
    return f"{words}, {turned} with a turn at a crossing, {excursions} with a way off the road{longer if long else ''}"


FRAME_OUT = Suite(
    name="frame-out",
    edition=2,
    summary="a target leaves the picture, as a car seen from a helicopter: where is it then, and is it found again?",
    scenes=(Scene("road-town", tuned_on=TuningEpisodes(seeds=range(300, 308), fresh=16)),),
    preset="standard",
    quick_preset="quick",
    judge=FrameOutJudge,
    metrics=(
        _rate("recovery_rate", "frame-outs after which the tracker is on the target within 5 frames", _RECOVERED),
        _rate("excursion_recovery_rate", "the same, of those with a way off the road", _RECOVERED, "excursion"),
        _rate("kept_rate", "frame-outs recovered and still on the target one second later", _KEPT),
        _rate("road_kept_rate", "the same, of frame-outs on the road", _KEPT, "road"),
        _rate("excursion_kept_rate", "the same, of those with a way off the road", _KEPT, "excursion"),
        _rate("kept_run_rate", "episodes with all judged frame-outs kept", _RUN_KEPT),
        _rate(
            "wrong_car_rate",
            "frame-outs after which the tracker is locked on another object",
            _WRONG_CAR,
            better="lower",
        ),
        Metric(
            "time_to_recover_frames",
            "mean time from back in full to on the target, never = 60 (Kaplan-Meier, restricted)",
            "frames",
            "lower",
            RestrictedMean(60, *recovery_times("frame-outs after which the target is back", FrameOut, Recovery)),
        ),
        _rate("had_rate", "frame-outs at whose exit the tracker had the target", _HAD),
        *_errors_outside(),
        Metric(
            "long_offscreen_error_m",
            "error on all frames of frame-outs that are longer than any that the preset draws",
            "m",
            "lower",
            Mean(_outside("offscreen_error_m", _OUT), kind="long"),
        ),
        Metric(
            _CAR_LENGTHS.name,
            "error on all frames outside, in lengths of the target",
            "car lengths",
            "lower",
            Mean(_CAR_LENGTHS),
        ),
        Metric(_REENTRY.name, "error on the last frame outside", "m", "lower", Mean(_REENTRY)),
        *map(_coverage, (0.5, 0.9, 0.95)),
        Metric(
            "nees",
            f"normalised error squared of the posterior outside, of a frame at most {NEES_CAP:g} (2 is right)",
            "1",
            "lower",
            Mean(_NEES_OUT),
            ideal=2.0,
        ),
        *in_view.IN_VIEW,
        Metric("precision", "VOT-LT precision", "fraction", "higher", BestPrecision(*_CURVES)),
        Metric("recall", "VOT-LT recall", "fraction", "higher", BestRecall(*_CURVES)),
        Metric(
            "f_measure",
            "VOT-LT F-score, at the confidence that makes it greatest",
            "fraction",
            "higher",
            BestF(*_CURVES),
        ),
        _in_pictures("centre_error_px", "centre error on frames in view", localisation.centre_error_px, "px"),
        _in_pictures(
            "precision_20_px", "frames in view with a centre error of at most 20 px (OTB)", localisation.centre_error_px
        ),
        _in_pictures("success_auc", "area under the success curve (OTB)", localisation.success_curve),
        *MASKS,
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
    events=EventWords(
        name="frame-outs",
        key="frame_out",
        tests={
            "all": lambda frame_out: True,
            "on the road": _is("kind", "road"),
            "off the road": _is("kind", "excursion"),
            "with a turn": _is("turned", True),
            "without a turn": _is("turned", False),
            "longer than drawn": _is("long", True),
            "as long as drawn": _is("long", False),
            **{f"left by the {side}": _is("side", side) for side in ("left", "right", "top", "bottom")},
            **{f"{low} to {high - 1} frames": _lasts(low, high) for low, high in pairwise(_LENGTHS)},
            f"{_LENGTHS[-1]} frames and more": _lasts(_LENGTHS[-1], float("inf")),
        },
        describe=_describe,
        compared=(
            _rate("recovered", "on the target within 5 frames", _RECOVERED),
            _rate("kept", "and still one second later", _KEPT),
            Metric("reentry_error_m", "error on the last frame outside", "m", "lower", Mean(_REENTRY)),
        ),
    ),
    silence=f"the worst error, {localisation.WORST_ERROR_M:g} m",
    references=ORACLES + TOLD,
    on_sequences=ON_SEQUENCES,
)
register_suite(FRAME_OUT)
