"""The suite ``harbour``: which intruders does a thermal camera find, how often does it raise a false alarm?

All episodes, of development and of test seeds, are of one site; for what was learnt on it see
``scenarios.harbour.scenario``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf

from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity, Statistic
from benchmarks.contract.suite import Scene, Suite, TuningEpisodes, register_suite
from benchmarks.judges.harbour import alarms, boxes, found, identity_scores, sizes
from benchmarks.judges.harbour.alarms import CAUSES
from benchmarks.judges.harbour.few_pictures import TAUGHT_BY_FEW
from benchmarks.judges.harbour.judge import HarbourJudge
from benchmarks.judges.harbour.matching import RADIUS_M
from benchmarks.judges.harbour.sizes import AT_100_M, DIMENSIONS
from benchmarks.judges.harbour.visits import EVENTS, KINDS
from benchmarks.judges.identities import identity_metrics
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.statistics.average_precision import LEAST_OVERLAP
from benchmarks.statistics.pooling import (
    AveragePrecision,
    DifferenceOfMedians,
    Froc,
    FrocAtATenth,
    Median,
    RatioOfMeans,
)

_SEEN = "intruders that can be seen, on the frames on which they are judged"
_SINGLE = "intruders that are judged, on every frame"
_TRACKED = "frames of intruders with a track on them"
_NEAR = f"{_TRACKED}, {AT_100_M[0]:g} to {AT_100_M[1]:g} m from the camera"
_FRAMES = "frames on which intruders are judged; what is neither right nor wrong is left out"
_CHANCE = "Frameout; chance taken off after Abbott, 1925"
_FROC = "FROC: Bunch et al., 1978; chance taken off after Abbott, 1925"
_COCO = "COCO: Lin et al., Microsoft COCO: common objects in context, ECCV 2014"
_GOSPA = "Rahmathullah, García-Fernández and Svensson, Generalized optimal sub-pattern assignment metric, FUSION 2017"

FOUND = Quantity("found", -inf, 1, _SEEN, _CHANCE, (found.visit_scores,))
_AS_IN_PAPER = Quantity("found_as_in_paper", 0, 1, "every intruder", "paper D", (found.visit_scores,))
CURVE = (
    Quantity("froc_found", -inf, inf, _SEEN, _FROC, (found.froc_scores,)),
    Quantity("froc_findable", 0, inf, _SEEN, _FROC, (found.froc_scores,)),
    Quantity("froc_alarms", 0, inf, _SEEN, _FROC, (alarms.froc_alarms,)),
    Quantity("watched_hours", 0, inf, _SEEN, _FROC, (alarms.alarm_scores,)),
)
"""What the FROC curve is made of."""
_ALARMS = "false_alarms_per_hour"
_OF_CAUSES = {
    cause: Quantity(f"{_ALARMS}_{cause}" if cause else _ALARMS, 0, inf, "whole episodes", OWN, (alarms.alarm_scores,))
    for cause in ("", *CAUSES)
}
"""Cause of false alarms -> their quantity; "": all."""
_CAUSE_WORDS = {
    "": "",
    "tide": " by moored boats and ropes",
    "wave": " by the sea",
    "bird": " by birds",
    "agc_step": " that begin with a step of the AGC",
    "shadow": " on land, by shadows and the like",
    "other": " by anything else",
}


def _area(name: str, low: float, high: float) -> Metric:
    words = f"mean detection rate over log alarms, {low:g} to {high:g} an hour"
    return Metric(name, words, "fraction", "higher", Froc(*CURVE, low=low, high=high))


FEW_ALARMS, MANY_ALARMS = _area("froc_area_01_10", 0.1, 10.0), _area("froc_area_1_100", 1.0, 100.0)
_TENTH = Metric(
    "detection_rate_at_a_tenth",
    "of pairs: detection rate with a tenth of the other's false alarms, minus what that finds with all of them",
    "fraction",
    "higher",
    FrocAtATenth(*CURVE, _OF_CAUSES[""], FOUND),
)


def _rate(
    name: str,
    summary: str,
    statistic: Statistic,
    better: Better = "higher",
) -> Metric:
    return Metric(name, summary, "fraction", better, statistic)


def _found_metrics() -> tuple[Metric, ...]:
    unseen = Quantity("found_unseen", -inf, 1, "intruders that cannot be seen", _CHANCE, (found.visit_scores,))
    chance = Quantity("chance_rate", 0, 1, _SEEN, _CHANCE, (found.visit_scores,))
    single = (
        Quantity(f"boxes_{each}", 0, inf, _SINGLE, _COCO, (boxes.box_scores,)) for each in ("right", "told", "true")
    )
    return (
        _rate("detection_rate", "intruders found that can be seen, chance taken off", Mean(FOUND)),
        *(_rate(f"detection_rate_{kind}", f"the same, class {kind}", Mean(FOUND, kind=kind)) for kind in KINDS),
        *(
            _rate(f"detection_rate_at_{n}", f"detection rate at {n} alarms an hour", Froc(*CURVE, high=n))
            for n in (1, 10, 100)
        ),
        FEW_ALARMS,
        MANY_ALARMS,
        _TENTH,
        _rate(
            "average_precision",
            f"average precision of boxes in single pictures, overlap {LEAST_OVERLAP:g}, as of COCO",
            AveragePrecision(*single),
        ),
        _rate("unseen_detection_rate", "intruders found that nobody could see", Mean(unseen)),
        _rate("chance_rate", "intruders found by chance", Mean(chance), "lower"),
        _rate("paper_detection_rate", "intruders found, counted as in paper D", Mean(_AS_IN_PAPER)),
        *(
            _rate(f"paper_detection_rate_{kind}", f"the same, class {kind}", Mean(_AS_IN_PAPER, kind=kind))
            for kind in KINDS
        ),
        _time_to_detect("time until an intruder is found, of those found"),
    )


def _time_to_detect(words: str) -> Metric:
    quantity = Quantity("time_to_detect_s", 0, inf, "intruders that are found", OWN, (found.visit_scores,))
    return Metric(quantity.name, words, "s", "lower", Median(quantity))


def _alarm_metrics() -> Iterator[Metric]:
    for cause, quantity in _OF_CAUSES.items():
        yield Metric(quantity.name, f"false alarms{_CAUSE_WORDS[cause]}", "1/h", "lower", Mean(quantity))
    by_tide = RatioOfMeans(_OF_CAUSES["tide"], _OF_CAUSES[""], high=1.0)
    yield _rate("tide_share", "of all false alarms those by moored boats", by_tide, "lower")
    tracks = Quantity("false_tracks_per_frame", 0, inf, "every frame", OWN, (alarms.alarm_scores,))
    yield Metric(tracks.name, "tracks on nothing on a frame", "1", "lower", Mean(tracks))


def _measured(name: str, high: float, conditions: str = _TRACKED, source: str = OWN) -> Quantity:
    return Quantity(name, 0, high, conditions, source, (sizes.measured_scores,))


def _size_error(name: str, words: str) -> Metric:
    return _rate(f"{name}_error", words, Median(_measured(f"{name}_error", inf, source="paper D")), "lower")


def _size_metrics() -> Iterator[Metric]:
    for name in DIMENSIONS:
        error = _measured(f"{name}_error", inf, source="paper D")
        near = _measured(f"{name}_error_at_100_m", inf, _NEAR, "paper D")
        of_mean = _measured(f"{name}_error_of_mean", inf, _NEAR)
        yield _size_error(name, f"error of the {name}")
        for kind in KINDS:
            words = f"error of a {kind}'s {name}"
            yield _rate(f"{name}_error_{kind}", words, Median(error, kind=kind), "lower")
            yield _rate(f"{name}_error_at_100_m_{kind}", f"{words}, 80 to 120 m away", Median(near, kind=kind), "lower")
            less = f"the same minus that of the mean {name} of the class"
            both = DifferenceOfMedians(near, of_mean, kind=kind)
            yield _rate(f"{name}_error_to_mean_{kind}", less, both, "lower")


def _position_error(words: str) -> Metric:
    return Metric("position_error_m", words, "m", "lower", Mean(_measured("position_error_m", RADIUS_M)))


def _kind_right() -> Metric:
    quantity = _measured("kind_right", 1, f"{_TRACKED} that names a class")
    return _rate("kind_right", "frames with the right class, of those with one", Mean(quantity))


def _duplicate_rate(words: str) -> Metric:
    return _rate("duplicate_rate", words, Mean(_measured("duplicate_rate", 1)), "lower")


_BEYOND = Quantity("beyond_m", -inf, inf, "tracks that paper D counts as found", OWN, (sizes.region_scores,))
_GOSPA_M = Quantity("gospa_m", 0, inf, _FRAMES, _GOSPA, (identity_scores.identity_scores,))

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
        _position_error("error over the ground of the track on an intruder"),
        Metric("beyond_m", "how far behind an intruder the tracks are placed", "m", "lower", Mean(_BEYOND), ideal=0.0),
        *_size_metrics(),
        _kind_right(),
        _duplicate_rate("frames of intruders with another track"),
        *identity_metrics("6 m over the ground", "3 m over the ground", _FRAMES, identity_scores.identity_scores),
        Metric("gospa_m", "GOSPA, order 1, cut-off 3 m over the ground", "m", "lower", Mean(_GOSPA_M)),
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
    events=replace(
        EVENTS,
        compared=(
            _rate("detection_rate", "found, chance taken off", Mean(FOUND)),
            _time_to_detect("time until found"),
            _position_error("error over the ground"),
            *(_size_error(name, f"error of the {name}") for name in ("width", "height", "depth")),
            _kind_right(),
            _duplicate_rate("frames with another track"),
        ),
        episodes=(FEW_ALARMS, MANY_ALARMS, _TENTH),
    ),
    silence="no track",
    references=tuple(TAUGHT_BY_FEW.values()),
    controller=None,
    follows_many=True,
    needs_depth=True,
)
register_suite(HARBOUR)
