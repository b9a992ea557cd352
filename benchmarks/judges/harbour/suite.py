"""The suite ``harbour``: which intruders does a thermal camera find, how often does it raise a false alarm?

All episodes, of development and of test seeds, are of one site; for what was learnt on it see
``scenarios.harbour.scenario``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from typing import Any

from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity, Statistic
from benchmarks.contract.suite import EventWords, Scene, Suite, TuningEpisodes, register_suite
from benchmarks.contract.text import counted
from benchmarks.judges.harbour import alarms, found, identity_scores, sizes
from benchmarks.judges.harbour.judge import HarbourJudge
from benchmarks.judges.harbour.matching import RADIUS_M
from benchmarks.judges.harbour.sizes import AT_100_M, DIMENSIONS
from benchmarks.judges.harbour.visits import KINDS, SEEABLE
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
_TRACKED = "frames of intruders with a track on them"
_NEAR = f"{_TRACKED}, {AT_100_M[0]:g} to {AT_100_M[1]:g} m from the camera"
_FRAMES = "frames on which intruders are judged; what is neither right nor wrong is left out"
_CHANCE = "Frameout; chance taken off after Abbott, 1925"
_FROC = "FROC: Bunch et al., 1978; chance taken off after Abbott, 1925"
_COCO = "COCO: Lin et al., Microsoft COCO: common objects in context, ECCV 2014"
_GOSPA = "Rahmathullah, García-Fernández and Svensson, Generalized optimal sub-pattern assignment metric, FUSION 2017"


def _quantity(
    name: str, conditions: str, by: Callable[..., Any], high: float = inf, low: float = 0, source: str = OWN
) -> Quantity:
    return Quantity(name, low, high, conditions, source, (by,))


def _rate(name: str, summary: str, statistic: Statistic, better: Better = "higher") -> Metric:
    return Metric(name, summary, "fraction", better, statistic)


def _area(name: str, low: float, high: float) -> Metric:
    words = f"mean detection rate over log alarms, {low:g} to {high:g} an hour"
    return _rate(name, words, Froc(*CURVE, low=low, high=high))


def _by_kind(name: str, summary: str, quantity: Quantity) -> Iterator[Metric]:
    """Yield the mean over all intruders, and over those of each class."""
    yield _rate(name, summary, Mean(quantity))
    yield from (_rate(f"{name}_{kind}", f"the same, class {kind}", Mean(quantity, kind=kind)) for kind in KINDS)


FOUND = _quantity("found", _SEEN, found.visit_scores, 1, low=-inf, source=_CHANCE)
CURVE = (
    _quantity("froc_found", _SEEN, found.froc_scores, low=-inf, source=_FROC),
    _quantity("froc_findable", _SEEN, found.froc_scores, source=_FROC),
    _quantity("froc_alarms", _SEEN, alarms.froc_alarms, source=_FROC),
    _quantity("watched_hours", _SEEN, alarms.alarm_scores, source=_FROC),
)
"""What the FROC curve is made of."""
FEW_ALARMS, MANY_ALARMS = _area("froc_area_01_10", 0.1, 10.0), _area("froc_area_1_100", 1.0, 100.0)
_ALARMS = _quantity("false_alarms_per_hour", "whole episodes", alarms.alarm_scores)
_TENTH = _rate(
    "detection_rate_at_a_tenth",
    "of pairs: detection rate with a tenth of the other's false alarms, minus what that finds with all of them",
    FrocAtATenth(*CURVE, _ALARMS, FOUND),
)
_CAUSE_WORDS = {
    "tide": "by moored boats and ropes",
    "wave": "by the sea",
    "bird": "by birds",
    "agc_step": "that begin with a step of the AGC",
    "shadow": "on land, by shadows and the like",
    "other": "by anything else",
}


def _found_metrics() -> Iterator[Metric]:
    chance = _quantity("chance_rate", _SEEN, found.visit_scores, 1, source=_CHANCE)
    as_in_paper = _quantity("found_as_in_paper", "every intruder", found.visit_scores, 1, source="paper D")
    yield from _by_kind("detection_rate", "intruders found that can be seen, chance taken off", FOUND)
    for count in (1, 10, 100):
        yield _rate(f"detection_rate_at_{count}", f"detection rate at {count} alarms an hour", Froc(*CURVE, high=count))
    yield from (FEW_ALARMS, MANY_ALARMS, _TENTH)
    single = "intruders that are judged, on every frame"
    boxes = (_quantity(f"boxes_{each}", single, found.box_scores, source=_COCO) for each in ("right", "told", "true"))
    words = f"average precision of boxes in single pictures, overlap {LEAST_OVERLAP:g}, as of COCO"
    yield _rate("average_precision", words, AveragePrecision(*boxes))
    yield _rate("chance_rate", "intruders found by chance", Mean(chance), "lower")
    yield from _by_kind("paper_detection_rate", "intruders found, counted as in paper D", as_in_paper)


def _alarm_metrics() -> Iterator[Metric]:
    yield Metric(_ALARMS.name, "false alarms", "1/h", "lower", Mean(_ALARMS))
    of_causes = {each: replace(_ALARMS, name=f"{_ALARMS.name}_{each}") for each in alarms.CAUSES}
    for cause, quantity in of_causes.items():
        yield Metric(quantity.name, f"false alarms {_CAUSE_WORDS[cause]}", "1/h", "lower", Mean(quantity))
    by_tide = RatioOfMeans(of_causes["tide"], _ALARMS, high=1.0)
    yield _rate("tide_share", "of all false alarms those by moored boats", by_tide, "lower")
    tracks = _quantity("false_tracks_per_frame", "every frame", alarms.alarm_scores)
    yield Metric(tracks.name, "tracks on nothing on a frame", "1", "lower", Mean(tracks))


_TO_DETECT = _quantity("time_to_detect_s", "intruders that are found", found.visit_scores)
_ERROR_M = _quantity("position_error_m", _TRACKED, sizes.measured_scores, RADIUS_M)
_RIGHT = _quantity("kind_right", f"{_TRACKED} that names a class", sizes.measured_scores, 1)
_TWICE = _quantity("duplicate_rate", _TRACKED, sizes.measured_scores, 1)
_BEYOND = _quantity("beyond_m", "tracks that paper D counts as found", sizes.region_scores, low=-inf)
_GOSPA_M = _quantity("gospa_m", _FRAMES, identity_scores.identity_scores, source=_GOSPA)
_SIZES = {name: _quantity(f"{name}_error", _TRACKED, sizes.measured_scores, source="paper D") for name in DIMENSIONS}

TO_DETECT = Metric(_TO_DETECT.name, "time until an intruder is found, of those found", "s", "lower", Median(_TO_DETECT))
PLACE = Metric(_ERROR_M.name, "error over the ground of the track on an intruder", "m", "lower", Mean(_ERROR_M))
KIND_RIGHT = _rate(_RIGHT.name, "frames with the right class, of those with one", Mean(_RIGHT))
DUPLICATES = _rate(_TWICE.name, "frames of intruders with another track", Mean(_TWICE), "lower")
SIZES = {name: _rate(of.name, f"error of the {name}", Median(of), "lower") for name, of in _SIZES.items()}


def _size_metrics() -> Iterator[Metric]:
    for name, error in SIZES.items():
        near = _quantity(f"{name}_error_at_100_m", _NEAR, sizes.measured_scores, source="paper D")
        of_mean = _quantity(f"{name}_error_of_mean", _NEAR, sizes.measured_scores)
        yield error
        for kind in KINDS:
            words = f"error of a {kind}'s {name}, 80 to 120 m away, minus that of the mean {name} of the class"
            yield _rate(f"{name}_error_to_mean_{kind}", words, DifferenceOfMedians(near, of_mean, kind=kind), "lower")


def _describe(events: Sequence[dict[str, Any]]) -> str:
    if not events:
        return "no intruders"
    counts = Counter(event["kind"] for event in events)
    kinds = ", ".join(f"{counts[kind]} × {kind}" for kind in KINDS if counts[kind])
    hidden = sum(not event["seeable"] for event in events)
    return f"{counted(len(events), 'intruder')} ({kinds}); {hidden or 'none'} of them too faint to see"


def _is(kind: str, event: dict[str, Any]) -> bool:
    return bool(event["kind"] == kind)


def _within(low: float, high: float, event: dict[str, Any]) -> bool:
    return bool(low <= event["contrast_to_noise"] < high)


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
        TO_DETECT,
        *_alarm_metrics(),
        PLACE,
        Metric("beyond_m", "how far behind an intruder the tracks are placed", "m", "lower", Mean(_BEYOND), ideal=0.0),
        *_size_metrics(),
        KIND_RIGHT,
        DUPLICATES,
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
    events=EventWords(
        name="visits",
        key="event",
        tests={
            "cars": partial(_is, "car"),
            "boats": partial(_is, "boat"),
            "people": partial(_is, "person"),
            # People have 75 to 950, mostly 150 to 300, cars and boats up to 5000.
            "contrast to noise 5 to 150": partial(_within, SEEABLE, 150.0),
            "contrast to noise 150 to 300": partial(_within, 150.0, 300.0),
            "contrast to noise 300 to 1000": partial(_within, 300.0, 1000.0),
            "contrast to noise from 1000": partial(_within, 1000.0, inf),
            "up to 60 s": lambda event: bool(event["length_frames"] <= 30),
            "longer than 60 s": lambda event: bool(event["length_frames"] > 30),
        },
        describe=_describe,
        compared=(
            _rate("detection_rate", "found, chance taken off", Mean(FOUND)),
            *(TO_DETECT, PLACE, *(SIZES[name] for name in ("width", "height", "depth")), KIND_RIGHT, DUPLICATES),
        ),
        episodes=(FEW_ALARMS, MANY_ALARMS, _TENTH),
    ),
    silence="no track",
    controller=None,
    follows_many=True,
    needs_depth=True,
)
register_suite(HARBOUR)
