"""The suite ``fish``: are lost pieces of track bridged, and does every fish keep its name?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf

from benchmarks.contract.metric import OWN, Mean, Metric, Quantity
from benchmarks.contract.suite import Scene, Suite, TuningEpisodes, register_suite
from benchmarks.judges.fish import gap_scores, judge, link_scores
from benchmarks.judges.fish.events import EVENTS
from benchmarks.judges.fish.gap_scores import GAP_FRAMES
from benchmarks.judges.fish.judge import AT_ONCE, FishJudge
from benchmarks.judges.fish.link_scores import GROUPS
from benchmarks.judges.fish.real import recordings
from benchmarks.judges.identities import identity_metrics
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.statistics.pooling import RatioOfMeans

_GROUP_WORDS = {
    "50": "gaps of at most 50 frames",
    "200": "gaps of at most 200 frames",
    "crossing_50": "those of at most 50 frames in which fish cross",
    "touching_50": "those of at most 50 frames in which none cross",
    "pair_50": "those of at most 50 frames with two fish",
    "crowd_50": "those of at most 50 frames with three or more fish",
}
_MADE = "gaps of pieces of track, of the group, that are linked"
_ALL = "gaps of pieces of track, of the group"
_NOW = ", as answered at once"
_LINK_MADE = Quantity("link_made", 0, 1, "every gap of pieces of track", OWN, (link_scores.link_events,))
_LINK_RIGHT = Quantity("link_right", 0, 1, "gaps of pieces of track that are linked", OWN, (link_scores.link_events,))


def _gap_metrics(count: int) -> Iterator[Metric]:
    bridged = f"gaps of {count} frames cut into true tracks, that the method bridges"
    regions = f"{bridged} with a region"

    def quantity(name: str, high: float, conditions: str, source: str = OWN) -> Quantity:
        return Quantity(name, 0, high, conditions, source, (gap_scores.gap_scores,))

    def error(name: str, words: str) -> Metric:
        return Metric(name, words, "px", "lower", Mean(quantity(name, inf, bridged, "paper C")))

    def coverage(name: str, words: str) -> Metric:
        words = f"true places inside the 95 % region{words}"
        return Metric(name, words, "fraction", "higher", Mean(quantity(name, 1, regions)), ideal=0.95)

    yield error(f"gap_error_{count}_px", f"error on the last of {count} lost frames")
    yield coverage(f"gap_coverage_{count}", f" then, {count} frames")
    yield error(f"gap_interpolation_error_{count}_px", f"mean error over {count} lost frames, far end known")
    yield coverage(f"gap_interpolation_coverage_{count}", f", {count} frames, far end known")
    own = quantity(f"successor_rate_{count}", 1, f"fish lost together for {count} frames")
    words = f"fish lost at once for {count} frames that get their own place at the end"
    yield Metric(own.name, words, "fraction", "higher", Mean(own))


_GAPS = {count: tuple(_gap_metrics(count)) for count in GAP_FRAMES}


def _growth(count: int) -> Metric:
    later, first = (of_count[0].statistic.of[0] for of_count in (_GAPS[count], _GAPS[GAP_FRAMES[0]]))
    words = f"error after {count} lost frames over that after {GAP_FRAMES[0]}"
    return Metric(f"gap_growth_{count}", words, "1", "lower", RatioOfMeans(later, first))


def _link_metrics(ending: str, when: str) -> Iterator[Metric]:
    for group in GROUPS:
        words = f"{_GROUP_WORDS[group]}{when}"
        for name, summary, conditions in (
            (f"link_precision_{group}", f"right links of those made, {words}", _MADE),
            (f"link_rate_{group}", f"links made, {words}", _ALL),
            (f"link_recall_{group}", f"right links, of all gaps, {words}", _ALL),
            (f"link_precision_{group}_of_90", f"right ones of the surest links over 90 % of {words}", _MADE),
        ):
            quantity = Quantity(f"{name}{ending}", 0, 1, conditions, OWN, (link_scores.link_scores,))
            yield Metric(quantity.name, summary, "fraction", "higher", Mean(quantity))


def _chain_metrics(ending: str, when: str) -> Iterator[Metric]:
    answers = "as answered at once" if when else "as revised at the end"
    frames = f"every frame, of the tracks {answers}"
    half = "half a body's length"
    yield from identity_metrics("a body's length", half, frames, judge.chain_scores, ending, when)
    for name, high, words in (
        ("missed_rate", 1, "frames of fish without a track"),
        ("false_rate", inf, "frames of tracks on no fish, per frame of a fish"),
    ):
        quantity = Quantity(f"{name}{ending}", 0, high, frames, OWN, (judge.chain_scores,))
        yield Metric(quantity.name, f"{words}{when}", "fraction", "lower", Mean(quantity))


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
        *(metric for of_count in _GAPS.values() for metric in of_count),
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
    events=replace(
        EVENTS,
        compared=(
            Metric("link_precision", "right links of those made", "fraction", "higher", Mean(_LINK_RIGHT)),
            Metric("link_rate", "links made", "fraction", "higher", Mean(_LINK_MADE)),
        ),
    ),
    silence="no track",
    controller=None,
    follows_many=True,
    recordings=recordings,
)
register_suite(FISH)
