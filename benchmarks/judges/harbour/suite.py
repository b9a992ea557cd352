"""The suite ``harbour``: which intruders does a thermal camera find, how often does it raise a false alarm?

All episodes, of development and of test seeds, are of one site; for what was learnt on it see
``scenarios.harbour.scenario``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

from benchmarks.contract.metric import Statistic
from benchmarks.contract.suite import Metric, Scene, Suite, register_suite
from benchmarks.contract.tuning_episodes import TuningEpisodes
from benchmarks.judges.harbour import alarms, boxes, found, identity_scores, sizes
from benchmarks.judges.harbour.alarms import CAUSES
from benchmarks.judges.harbour.few_pictures import TAUGHT_BY_FEW
from benchmarks.judges.harbour.judge import HarbourJudge
from benchmarks.judges.harbour.row_meanings import ROW_MEANINGS
from benchmarks.judges.harbour.sizes import DIMENSIONS
from benchmarks.judges.harbour.visits import EVENTS, KINDS
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.statistics.average_precision import LEAST_OVERLAP

FROC_ROWS = ("froc_found", "froc_findable", "froc_alarms", "watched_hours")


def _area(name: str, low: float, high: float) -> Metric:
    words = f"mean detection rate over log alarms, {low:g} to {high:g} an hour"
    return Metric(name, words, "fraction", "higher", FROC_ROWS, "froc", alarms_per_hour=(low, high))


FEW_ALARMS, MANY_ALARMS = _area("froc_area_01_10", 0.1, 10.0), _area("froc_area_1_100", 1.0, 100.0)
_IDENTITY_ROWS = ("identity_right_frames", "identity_false_frames", "identity_missed_frames")
_CAUSE_WORDS = {
    "tide": "by moored boats and ropes",
    "wave": "by the sea",
    "bird": "by birds",
    "agc_step": "that begin with a step of the AGC",
    "shadow": "on land, by shadows and the like",
    "other": "by anything else",
}
_TENTH = Metric(
    "detection_rate_at_a_tenth",
    "of pairs: detection rate with a tenth of the other's false alarms, minus what that finds with all of them",
    "fraction",
    "higher",
    (*FROC_ROWS, "false_alarms_per_hour", "found"),
    "froc at a tenth",
)


def _rate(
    name: str,
    summary: str,
    better: Literal["higher", "lower"] = "higher",
    rows: tuple[str, ...] = (),
    statistic: Statistic = "mean",
    kind: str | None = None,
) -> Metric:
    return Metric(name, summary, "fraction", better, rows, statistic, kind)


def _froc(name: str, summary: str, *alarms_per_hour: float) -> Metric:
    return Metric(name, summary, "fraction", "higher", FROC_ROWS, "froc", alarms_per_hour=alarms_per_hour)


def _found_metrics() -> tuple[Metric, ...]:
    found, region = ("found",), ("found_as_in_paper",)
    return (
        _rate("detection_rate", "intruders found that can be seen, chance taken off", rows=found),
        *(_rate(f"detection_rate_{kind}", f"the same, class {kind}", rows=found, kind=kind) for kind in KINDS),
        *(_froc(f"detection_rate_at_{n}", f"detection rate at {n} alarms an hour", n) for n in (1, 10, 100)),
        FEW_ALARMS,
        MANY_ALARMS,
        _TENTH,
        _rate(
            "average_precision",
            f"average precision of boxes in single pictures, overlap {LEAST_OVERLAP:g}, as of COCO",
            rows=("boxes_right", "boxes_told", "boxes_true"),
            statistic="average precision",
        ),
        _rate("unseen_detection_rate", "intruders found that nobody could see", rows=("found_unseen",)),
        _rate("chance_rate", "intruders found by chance", "lower"),
        _rate("paper_detection_rate", "intruders found, counted as in paper D", rows=region),
        *(_rate(f"paper_detection_rate_{kind}", f"the same, class {kind}", rows=region, kind=kind) for kind in KINDS),
        Metric("time_to_detect_s", "time until an intruder is found, of those found", "s", "lower", statistic="median"),
    )


def _alarm_metrics() -> tuple[Metric, ...]:
    every = "false_alarms_per_hour"
    tide = f"{every}_tide", every
    return (
        Metric(every, "false alarms", "1/h", "lower"),
        *(Metric(f"{every}_{cause}", f"false alarms {_CAUSE_WORDS[cause]}", "1/h", "lower") for cause in CAUSES),
        _rate("tide_share", "of all false alarms those by moored boats", "lower", tide, "ratio of means"),
        Metric("false_tracks_per_frame", "tracks on nothing on a frame", "1", "lower"),
    )


def _size_metrics() -> Iterator[Metric]:
    for name in DIMENSIONS:
        error, near = (f"{name}_error",), (f"{name}_error_at_100_m",)
        yield _rate(f"{name}_error", f"error of the {name}", "lower", error, "median")
        for kind in KINDS:
            words = f"error of a {kind}'s {name}"
            yield _rate(f"{name}_error_{kind}", words, "lower", error, "median", kind)
            yield _rate(f"{name}_error_at_100_m_{kind}", f"{words}, 80 to 120 m away", "lower", near, "median", kind)
            less = f"the same minus that of the mean {name} of the class"
            both = *near, f"{name}_error_of_mean"
            yield _rate(f"{name}_error_to_mean_{kind}", less, "lower", both, "difference of medians", kind)


HARBOUR = Suite(
    name="harbour",
    edition=2,
    summary="a harbour through a thermal camera: which intruders are found, and how often is it a false alarm? All "
    "presets and both splits are of one site, on which confidences, places, tuned values and settings were learnt",
    scenes=(Scene("harbour", tuned_on=TuningEpisodes("ten-minutes", fresh_presets=("standard",))),),
    preset="standard",
    quick_preset="quick",
    judge=HarbourJudge,
    metrics=(
        *_found_metrics(),
        *_alarm_metrics(),
        Metric("position_error_m", "error over the ground of the track on an intruder", "m", "lower"),
        Metric("beyond_m", "how far behind an intruder the tracks are placed", "m", "lower", ideal=0.0),
        *_size_metrics(),
        _rate("kind_right", "frames with the right class, of those with one"),
        _rate("duplicate_rate", "frames of intruders with another track", "lower"),
        _rate("hota", "HOTA, similarity 0 at 6 m over the ground"),
        _rate("idf1", "IDF1, within 3 m over the ground", rows=_IDENTITY_ROWS, statistic="f of counts"),
        _rate("mota", "MOTA of CLEAR, within 3 m over the ground"),
        Metric("identity_switches", "switches of CLEAR in an episode", "1", "lower"),
        Metric("gospa_m", "GOSPA, order 1, cut-off 3 m over the ground", "m", "lower"),
        *SPEED,
    ),
    headline=(
        "detection_rate_at_1",
        "froc_area_01_10",
        "froc_area_1_100",
        "average_precision",
        "detection_rate",
        "false_alarms_per_hour",
        "position_error_m",
        "width_error",
        "height_error",
        "depth_error",
        "hota",
        "frames_per_s",
    ),
    compared=(
        "detection_rate_at_1",
        "froc_area_01_10",
        "froc_area_1_100",
        "average_precision",
        "detection_rate",
        "detection_rate_at_10",
        "detection_rate_at_a_tenth",
        "false_alarms_per_hour",
        "position_error_m",
        "width_error",
        "height_error",
        "depth_error",
        "hota",
        "idf1",
        "gospa_m",
    ),
    tuned_for={MANY_ALARMS.name: 1.0},
    events=replace(EVENTS, episodes=(FEW_ALARMS, MANY_ALARMS, _TENTH)),
    silence="no track",
    references=tuple(TAUGHT_BY_FEW.values()),
    controller=None,
    follows_many=True,
    needs_depth=True,
    definitions={
        found.visit_scores: ("found", "found_unseen", "chance_rate", "found_as_in_paper", "time_to_detect_s"),
        found.froc_scores: ("froc_found", "froc_findable"),
        alarms.alarm_scores: (
            "false_alarms_per_hour",
            *(f"false_alarms_per_hour_{cause}" for cause in CAUSES),
            "false_tracks_per_frame",
            "watched_hours",
        ),
        alarms.froc_alarms: ("froc_alarms",),
        boxes.box_scores: ("boxes_right", "boxes_told", "boxes_true"),
        sizes.measured_scores: (
            "position_error_m",
            "duplicate_rate",
            "kind_right",
            *(f"{name}_{error}" for error in ("error", "error_at_100_m", "error_of_mean") for name in DIMENSIONS),
        ),
        sizes.region_scores: ("beyond_m",),
        identity_scores.identity_scores: (
            "hota",
            "mota",
            "identity_switches",
            *_IDENTITY_ROWS,
            "gospa_m",
        ),
    },
    row_meanings=ROW_MEANINGS,
)
register_suite(HARBOUR)
