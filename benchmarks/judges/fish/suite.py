"""The suite ``fish``: are lost pieces of track bridged, and does every fish keep its name?"""

from __future__ import annotations

from typing import Literal

from benchmarks.contract.suite import Metric, Scene, Suite, register_suite
from benchmarks.contract.tuning_episodes import TuningEpisodes
from benchmarks.judges.fish import gap_scores, judge, link_scores, motion
from benchmarks.judges.fish.events import EVENTS
from benchmarks.judges.fish.gap_scores import GAP_FRAMES
from benchmarks.judges.fish.judge import AT_ONCE, FishJudge
from benchmarks.judges.fish.link_scores import GROUPS
from benchmarks.judges.fish.motion import MOTION
from benchmarks.judges.fish.real import recordings
from benchmarks.judges.fish.row_meanings import ROW_MEANINGS
from benchmarks.judges.tracker_speed import SPEED

_GROUP_WORDS = {
    "50": "gaps of at most 50 frames",
    "200": "gaps of at most 200 frames",
    "crossing_50": "those of at most 50 frames in which fish cross",
    "touching_50": "those of at most 50 frames in which none cross",
    "pair_50": "those of at most 50 frames with two fish",
    "crowd_50": "those of at most 50 frames with three or more fish",
}
_CHAIN_ROWS = ("hota", "mota", "identity_switches", "missed_rate", "false_rate")
_IDENTITY_ROWS = ("identity_right_frames", "identity_false_frames", "identity_missed_frames")
_LINK_KINDS = ("link_precision_{}", "link_rate_{}", "link_recall_{}", "link_precision_{}_of_90")


def _rate(name: str, summary: str, better: Literal["higher", "lower"] = "higher") -> Metric:
    return Metric(name, summary, "fraction", better)


def _gap_metrics(count: int) -> tuple[Metric, ...]:
    return (
        Metric(f"gap_error_{count}_px", f"error on the last of {count} lost frames", "px", "lower"),
        Metric(
            f"gap_coverage_{count}",
            f"true places inside the 95 % region then, {count} frames",
            "fraction",
            "higher",
            ideal=0.95,
        ),
        Metric(
            f"gap_interpolation_error_{count}_px", f"mean error over {count} lost frames, far end known", "px", "lower"
        ),
        Metric(
            f"gap_interpolation_coverage_{count}",
            f"true places inside the 95 % region, {count} frames, far end known",
            "fraction",
            "higher",
            ideal=0.95,
        ),
        _rate(f"successor_rate_{count}", f"fish lost at once for {count} frames that get their own place at the end"),
    )


def _growth(count: int) -> Metric:
    rows = (f"gap_error_{count}_px", f"gap_error_{GAP_FRAMES[0]}_px")
    words = f"error after {count} lost frames over that after {GAP_FRAMES[0]}"
    return Metric(f"gap_growth_{count}", words, "1", "lower", rows, "ratio of means")


def _link_metrics(ending: str, when: str) -> tuple[Metric, ...]:
    metrics = []
    for group in GROUPS:
        words = f"{_GROUP_WORDS[group]}{when}"
        metrics += [
            _rate(f"link_precision_{group}{ending}", f"right links of those made, {words}"),
            _rate(f"link_rate_{group}{ending}", f"links made, {words}"),
            _rate(f"link_recall_{group}{ending}", f"right links, of all gaps, {words}"),
            _rate(f"link_precision_{group}_of_90{ending}", f"right ones of the surest links over 90 % of {words}"),
        ]
    return tuple(metrics)


def _chain_metrics(ending: str, when: str) -> tuple[Metric, ...]:
    counts = tuple(f"{name}{ending}" for name in _IDENTITY_ROWS)
    return (
        _rate(f"hota{ending}", f"HOTA, similarity 0 at a body's length{when}"),
        Metric(
            f"idf1{ending}", f"IDF1, within half a body's length{when}", "fraction", "higher", counts, "f of counts"
        ),
        _rate(f"mota{ending}", f"MOTA of CLEAR, within half a body's length{when}"),
        Metric(f"identity_switches{ending}", f"switches of CLEAR in an episode{when}", "1", "lower"),
        _rate(f"missed_rate{ending}", f"frames of fish without a track{when}", "lower"),
        _rate(f"false_rate{ending}", f"frames of tracks on no fish, per frame of a fish{when}", "lower"),
    )


_NOW = ", as answered at once"
_CHAIN_NAMES = (*_CHAIN_ROWS, *_IDENTITY_ROWS)
_LINK_NAMES = tuple(kind.format(group) for group in GROUPS for kind in _LINK_KINDS)
_GAP_NAMES = tuple(metric.name for count in GAP_FRAMES for metric in _gap_metrics(count))

FISH = Suite(
    name="fish",
    edition=2,
    summary="fish in a tank from above: are lost pieces of track bridged, and does every fish keep its name?",
    scenes=(
        Scene(
            "fish-tank",
            tuned_on=TuningEpisodes(seeds=range(300, 302), fresh_presets=("standard", "hard")),
        ),
    ),
    preset="standard",
    quick_preset="quick",
    judge=FishJudge,
    metrics=(
        *_chain_metrics("", ""),
        *_link_metrics("", ""),
        *(metric for count in GAP_FRAMES for metric in _gap_metrics(count)),
        *(_growth(count) for count in GAP_FRAMES[1:]),
        *_chain_metrics(AT_ONCE, _NOW),
        *_link_metrics(AT_ONCE, _NOW),
        *SPEED,
    ),
    headline=(
        "hota",
        "idf1",
        "link_precision_50",
        "link_rate_50",
        "link_precision_200",
        "gap_error_50_px",
        "gap_error_100_px",
        "gap_error_200_px",
        "gap_interpolation_error_50_px",
        "frames_per_s",
    ),
    compared=(
        "hota",
        "idf1",
        f"hota{AT_ONCE}",
        f"idf1{AT_ONCE}",
        "link_precision_50_of_90",
        "gap_error_50_px",
        "gap_error_100_px",
        "gap_error_200_px",
        "gap_interpolation_error_50_px",
        "gap_interpolation_error_100_px",
        "gap_interpolation_error_200_px",
    ),
    # Methods that only bridge gaps have neither identities nor HOTA: they can better the error after a gap, or in it.
    tuned_for={"idf1": 1.0, "hota": 1.0, "gap_error_50_px": -0.001, "gap_interpolation_error_50_px": -0.001},
    events=EVENTS,
    silence="no track",
    controller=None,
    follows_many=True,
    recordings=recordings,
    definitions={
        judge.chain_scores: (*_CHAIN_NAMES, *(f"{name}{AT_ONCE}" for name in _CHAIN_NAMES)),
        link_scores.link_scores: (*_LINK_NAMES, *(f"{name}{AT_ONCE}" for name in _LINK_NAMES)),
        link_scores.link_events: ("link_made", "link_right"),
        gap_scores.gap_scores: _GAP_NAMES,
        motion.motion_scores: tuple(row for metric in MOTION for row in metric.rows),
    },
    row_meanings=ROW_MEANINGS,
)
register_suite(FISH)
