"""The suite ``stereo``: a person followed among others, by a stereo camera on a robot, under changing light."""

from __future__ import annotations

from benchmarks.contract.metric import Statistic
from benchmarks.contract.suite import Metric, Scene, Suite, register_suite
from benchmarks.judges.recovery import Recovery
from benchmarks.judges.stereo.disparity import DISPARITY
from benchmarks.judges.stereo.events import EVENT_COUNTS, EVENTS
from benchmarks.judges.stereo.judge import StereoJudge
from benchmarks.judges.stereo.metrics import disparity, people
from benchmarks.judges.stereo.metrics.people_events import LIGHT_KINDS, NEAR, NOBODY_NEAR, PeopleEvent
from benchmarks.judges.stereo.row_meanings import ROW_MEANINGS
from benchmarks.judges.tracker_speed import SPEED

_COUNTS = ("right_frames", "wrong_frames", "missed_frames")


def _counted(name: str, summary: str, statistic: Statistic) -> Metric:
    return Metric(name, summary, "fraction", "higher", _COUNTS, statistic)


def _f1_of(name: str, summary: str, kind: str) -> Metric:
    return Metric(name, summary, "fraction", "higher", EVENT_COUNTS, "detection f1 of counts", kind)


def _error(name: str, summary: str) -> Metric:
    return Metric(name, summary, "m", "lower")


STEREO = Suite(
    name="stereo",
    edition=2,
    summary="a stereo camera follows a person among others under changing light: is it still the same person?",
    scenes=(Scene("stereo-follow"), Scene("paper-sheet")),
    preset="standard",
    quick_preset="quick",
    judge=StereoJudge,
    metrics=(
        _counted(
            "detection_f1",
            "F1 with a wrong answer as a false positive and a miss: 2 A / (2 A + 2 B + C)",
            "detection f1 of counts",
        ),
        _counted("precision", "A / (A + B), the share of answers within 0.5 m of the target", "precision of counts"),
        _counted("recall", "A / (A + C), C = frames with the target visible and no answer", "recall of counts"),
        _counted("f_measure", "2 P R / (P + R) as in paper B: a wrong answer is no miss", "f of counts"),
        Metric("wrong_person_rate", "frames on another person", "fraction", "lower"),
        _error("position_error_m", "error on frames on which the target is seen, at most 5 m; 5 m without an answer"),
        _error("position_error_found_m", "error on frames with a right answer"),
        Metric(
            "occlusion_recovery_rate",
            "occlusions after which the tracker is on the target within 10 frames",
            "fraction",
            "higher",
            ("recovered",),
        ),
        Metric(
            "wrong_after_occlusion_rate",
            "occlusions after which the tracker is locked on another person",
            "fraction",
            "lower",
            ("locked_on_wrong_person",),
        ),
        Metric(
            "time_to_recover_s",
            "mean time from half seen again to on the target, never = 60 frames (Kaplan-Meier, restricted)",
            "s",
            "lower",
            ("recovery_frames", "watched_frames", "rate_hz"),
            "restricted mean",
        ),
        *(_f1_of(f"f1_after_{kind.replace(' ', '_')}", f"F1 in the 2 s after: {kind}", kind) for kind in LIGHT_KINDS),
        Metric(
            "wrong_after_light_rate",
            "frames on another person, of those in the 2 s after a change of light",
            "fraction",
            "lower",
            ("event_wrong_person_rate",),
            kind="light",
        ),
        _f1_of("f1_near_person", "F1 on frames with another person within 1.5 m of the camera and in view", NEAR),
        _f1_of("f1_no_near_person", "F1 on frames without one", NOBODY_NEAR),
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
    events=EVENTS,
    silence="no answer; it is a miss where at least a tenth of the person is seen",
    controller=None,
    definitions={
        people: ("right_frames", "wrong_frames", "missed_frames", *EVENT_COUNTS),
        people.on_other: ("wrong_person_rate", "event_wrong_person_rate", "locked_on_wrong_person"),
        people.position_error_m: ("position_error_m", "position_error_found_m"),
        PeopleEvent: ("recovered", "recovery_frames", "watched_frames", "event_wrong_person_rate", *EVENT_COUNTS),
        Recovery: ("recovered", "recovery_frames", "watched_frames", "locked_on_wrong_person"),
        people.PeopleSeries: ("rate_hz",),
        disparity: tuple(row for metric in DISPARITY for row in metric.rows),
        disparity.DisparityErrors.median_px: ("disparity_error_px",),
        disparity.DisparityErrors.bad_1: ("disparity_bad_1",),
        disparity.DisparityErrors.bad_3: ("disparity_bad_3",),
        disparity.DisparityErrors.density: ("disparity_density",),
    },
    row_meanings=ROW_MEANINGS,
)
register_suite(STEREO)
