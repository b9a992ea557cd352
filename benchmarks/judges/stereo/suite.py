"""The suite ``stereo``: a person followed among others, by a stereo camera on a robot, under changing light."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from benchmarks.contract.metric import OWN, Mean, Metric, Quantity
from benchmarks.contract.suite import Scene, Suite, register_suite
from benchmarks.judges.recovery import Recovery, recovery_times
from benchmarks.judges.stereo.events import EVENTS
from benchmarks.judges.stereo.judge import StereoJudge
from benchmarks.judges.stereo.metrics import people
from benchmarks.judges.stereo.metrics.people_events import LIGHT_KINDS, NEAR, NOBODY_NEAR, PeopleEvent
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.statistics.pooling import RestrictedMean, detection_f1_of, f_of, precision_of, recall_of

_COUNTED = "frames but the first on which the person is seen at all"
_OCCLUSIONS = "occlusions with at least 10 frames of the episode after half of the person is seen again"

COUNTS = [
    Quantity(f"{kind}_frames", 0, inf, _COUNTED, "paper B; detection_f1: Frameout", (people,))
    for kind in ("right", "wrong", "missed")
]
_EVENT_COUNTS = [
    Quantity(f"event_{each.name}", 0, inf, f"{_COUNTED}, of the event", OWN, (people, PeopleEvent)) for each in COUNTS
]
_WRONG_IN_EVENT = Quantity("event_wrong_person_rate", 0, 1, "frames of the event", OWN, (people.on_other, PeopleEvent))
_RECOVERED = Quantity("recovered", 0, 1, _OCCLUSIONS, OWN, (PeopleEvent, Recovery))


def _error(name: str, summary: str, high: float, conditions: str) -> Metric:
    quantity = Quantity(name, 0, high, conditions, OWN, (people.position_error_m,))
    return Metric(name, summary, "m", "lower", Mean(quantity))


def event_f1(name: str, summary: str, kind: str | None) -> Metric:
    """Return the F1 over the frames of the events of a kind, None = of all that are compared."""
    return Metric(name, summary, "fraction", "higher", detection_f1_of(*_EVENT_COUNTS, kind=kind))


STEREO = Suite(
    name="stereo",
    edition=2,
    summary="a stereo camera follows a person among others under changing light: is it still the same person?",
    scenes=(Scene("stereo-follow"), Scene("paper-sheet")),
    preset="standard",
    quick_preset="quick",
    judge=StereoJudge,
    metrics=(
        Metric(
            "detection_f1",
            "F1 with a wrong answer as a false positive and a miss: 2 A / (2 A + 2 B + C)",
            "fraction",
            "higher",
            detection_f1_of(*COUNTS),
        ),
        Metric(
            "precision",
            "A / (A + B), the share of answers within 0.5 m of the target",
            "fraction",
            "higher",
            precision_of(*COUNTS),
        ),
        Metric(
            "recall",
            "A / (A + C), C = frames with the target visible and no answer",
            "fraction",
            "higher",
            recall_of(*COUNTS),
        ),
        Metric(
            "f_measure", "2 P R / (P + R) as in paper B: a wrong answer is no miss", "fraction", "higher", f_of(*COUNTS)
        ),
        Metric(
            "wrong_person_rate",
            "frames on another person",
            "fraction",
            "lower",
            Mean(Quantity("wrong_person_rate", 0, 1, "every frame but the first", OWN, (people.on_other,))),
        ),
        _error(
            "position_error_m",
            "error on frames on which the target is seen, at most 5 m; 5 m without an answer",
            people.WORST_ERROR_M,
            "frames but the first with at least a tenth of the person seen",
        ),
        _error(
            "position_error_found_m",
            "error on frames with a right answer",
            people.RIGHT_WITHIN_M,
            "frames with a right answer",
        ),
        Metric(
            "occlusion_recovery_rate",
            "occlusions after which the tracker is on the target within 10 frames",
            "fraction",
            "higher",
            Mean(_RECOVERED),
        ),
        Metric(
            "wrong_after_occlusion_rate",
            "occlusions after which the tracker is locked on another person",
            "fraction",
            "lower",
            Mean(Quantity("locked_on_wrong_person", 0, 1, _OCCLUSIONS, OWN, (people.on_other, Recovery))),
        ),
        Metric(
            "time_to_recover_s",
            "mean time from half seen again to on the target, never = 60 frames (Kaplan-Meier, restricted)",
            "s",
            "lower",
            RestrictedMean(
                60,
                *recovery_times("occlusions after which half of the person is seen again", PeopleEvent, Recovery),
                Quantity("rate_hz", 0, inf, "", OWN, (people.PeopleSeries,)),
            ),
        ),
        *(event_f1(f"f1_after_{kind.replace(' ', '_')}", f"F1 in the 2 s after: {kind}", kind) for kind in LIGHT_KINDS),
        Metric(
            "wrong_after_light_rate",
            "frames on another person, of those in the 2 s after a change of light",
            "fraction",
            "lower",
            Mean(_WRONG_IN_EVENT, kind="light"),
        ),
        event_f1("f1_near_person", "F1 on frames with another person within 1.5 m of the camera and in view", NEAR),
        event_f1("f1_no_near_person", "F1 on frames without one", NOBODY_NEAR),
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
    events=replace(
        EVENTS,
        compared=(
            Metric("recovered", "on the target within 10 frames", "fraction", "higher", Mean(_RECOVERED)),
            event_f1("detection_f1", "F1 over its frames", None),
            Metric("wrong_person_rate", "its frames on another person", "fraction", "lower", Mean(_WRONG_IN_EVENT)),
        ),
    ),
    silence="no answer; it is a miss where at least a tenth of the person is seen",
    controller=None,
)
register_suite(STEREO)
