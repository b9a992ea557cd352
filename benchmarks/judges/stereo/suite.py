"""The suite ``stereo``: a person followed among others, by a stereo camera on a robot, under changing light."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import inf
from typing import Any

from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity, Statistic
from benchmarks.contract.suite import EventTest, EventWords, Scene, Suite, register_suite
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges.masks import MASKS
from benchmarks.judges.recovery import Recovery, recovery_times
from benchmarks.judges.stereo.judge import StereoJudge
from benchmarks.judges.stereo.metrics import people
from benchmarks.judges.stereo.metrics.people_events import LIGHT_KINDS, NEAR, NOBODY_NEAR, OCCLUSION, PeopleEvent
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.statistics.pooling import RestrictedMean, detection_f1_of, f_of, precision_of, recall_of

_COUNTED = "frames but the first on which the person is seen at all"
_OCCLUSIONS = "occlusions with at least 10 frames of the episode after half of the person is seen again"
_SEEN = "frames but the first with at least a tenth of the person seen"


def _quantity(name: str, conditions: str, *defined_by: Any, high: float = 1, source: str = OWN) -> Quantity:
    return Quantity(name, 0, high, conditions, source, defined_by)


_COUNTS = [
    _quantity(f"{kind}_frames", _COUNTED, people, high=inf, source="paper B; detection_f1: Frameout")
    for kind in ("right", "wrong", "missed")
]
_EVENT_COUNTS = [
    _quantity(f"event_{each.name}", f"{_COUNTED}, of the event", people, PeopleEvent, high=inf) for each in _COUNTS
]
_WRONG = _quantity("wrong_person_rate", "every frame but the first", people.on_other)
_WRONG_IN_EVENT = _quantity("event_wrong_person_rate", "frames of the event", people.on_other, PeopleEvent)
_RECOVERED = _quantity("recovered", _OCCLUSIONS, PeopleEvent, Recovery)
_LOCKED = _quantity("locked_on_wrong_person", _OCCLUSIONS, people.on_other, Recovery)
_TIMES = recovery_times("occlusions after which half of the person is seen again", PeopleEvent, Recovery)


def _share(name: str, summary: str, statistic: Statistic, better: Better = "higher") -> Metric:
    return Metric(name, summary, "fraction", better, statistic)


def _error(name: str, summary: str, high: float, conditions: str) -> Metric:
    return Metric(name, summary, "m", "lower", Mean(_quantity(name, conditions, people.position_error_m, high=high)))


def event_f1(name: str, summary: str, kind: str | None) -> Metric:
    """Return the F1 over the frames of the events of a kind, None = of all that are compared."""
    return _share(name, summary, detection_f1_of(*_EVENT_COUNTS, kind=kind))


def _is(kind: str) -> EventTest:
    return lambda event: bool(event["kind"] == kind)


def _describe(events: Sequence[dict[str, Any]]) -> str:
    lengths = [event["length_frames"] for event in events if event["kind"] == OCCLUSION]
    lights = Counter(event["kind"] for event in events if event["light"])
    hidden = counted(len(lengths), "occlusion")
    changes = counted(lights.total(), "change of light", "changes of light")
    if lengths:
        hidden += f" of {lengths_text(lengths)}"
    if lights:
        changes += f" ({', '.join(f'{lights[kind]} × {kind}' for kind in LIGHT_KINDS if kind in lights)})"
    return f"{hidden}, {changes}"


STEREO = Suite(
    name="stereo",
    edition=2,
    summary="a stereo camera follows a person among others under changing light: is it still the same person?",
    scenes=(Scene("stereo-follow"), Scene("paper-sheet")),
    preset="standard",
    quick_preset="quick",
    judge=StereoJudge,
    metrics=(
        _share(
            "detection_f1",
            "F1 with a wrong answer as a false positive and a miss: 2 A / (2 A + 2 B + C)",
            detection_f1_of(*_COUNTS),
        ),
        _share("precision", "A / (A + B), the share of answers within 0.5 m of the target", precision_of(*_COUNTS)),
        _share("recall", "A / (A + C), C = frames with the target visible and no answer", recall_of(*_COUNTS)),
        _share("f_measure", "2 P R / (P + R) as in paper B: a wrong answer is no miss", f_of(*_COUNTS)),
        _share("wrong_person_rate", "frames on another person", Mean(_WRONG), "lower"),
        _error(
            "position_error_m",
            "error on frames on which the target is seen, at most 5 m; 5 m without an answer",
            people.WORST_ERROR_M,
            _SEEN,
        ),
        _error(
            "position_error_found_m",
            "error on frames with a right answer",
            people.RIGHT_WITHIN_M,
            "frames with a right answer",
        ),
        _share(
            "occlusion_recovery_rate",
            "occlusions after which the tracker is on the target within 10 frames",
            Mean(_RECOVERED),
        ),
        _share(
            "wrong_after_occlusion_rate",
            "occlusions after which the tracker is locked on another person",
            Mean(_LOCKED),
            "lower",
        ),
        Metric(
            "time_to_recover_s",
            "mean time from half seen again to on the target, never = 60 frames (Kaplan-Meier, restricted)",
            "s",
            "lower",
            RestrictedMean(60, *_TIMES, _quantity("rate_hz", "", people.PeopleSeries, high=inf)),
        ),
        *(event_f1(f"f1_after_{kind.replace(' ', '_')}", f"F1 in the 2 s after: {kind}", kind) for kind in LIGHT_KINDS),
        _share(
            "wrong_after_light_rate",
            "frames on another person, of those in the 2 s after a change of light",
            Mean(_WRONG_IN_EVENT, kind="light"),
            "lower",
        ),
        event_f1("f1_near_person", "F1 on frames with another person within 1.5 m of the camera and in view", NEAR),
        event_f1("f1_no_near_person", "F1 on frames without one", NOBODY_NEAR),
        *MASKS,
        *SPEED,
    ),
    headline=(
        "detection_f1",
        "f_measure",
        "precision",
        "recall",
        "wrong_person_rate",
        "position_error_m",
        "occlusion_recovery_rate",
        "frames_per_s",
    ),
    compared=("detection_f1", "precision", "recall", "wrong_person_rate", "occlusion_recovery_rate"),
    tuned_for={"detection_f1": 1.0, "wrong_person_rate": -1.0},
    events=EventWords(
        name="events",
        key="event",
        tests={
            "occlusions": _is(OCCLUSION),
            "2 s after any change of light": lambda event: bool(event["light"]),
            **{f"2 s after {kind}": _is(kind) for kind in LIGHT_KINDS},
            NEAR: _is(NEAR),
            NOBODY_NEAR: _is(NOBODY_NEAR),
        },
        describe=_describe,
        compared=(
            _share("recovered", "on the target within 10 frames", Mean(_RECOVERED)),
            event_f1("detection_f1", "F1 over its frames", None),
            _share("wrong_person_rate", "its frames on another person", Mean(_WRONG_IN_EVENT), "lower"),
        ),
    ),
    silence="a miss where at least a tenth of the person is seen",
    controller=None,
)
register_suite(STEREO)
