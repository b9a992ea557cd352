"""The suite ``fish``: are lost pieces of track bridged, and does every fish keep its name?"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import inf
from typing import Any

from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity
from benchmarks.contract.suite import EventWords, Scene, Suite, TuningEpisodes, register_suite
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges.fish.gap_protocol import GAP_FRAMES
from benchmarks.judges.fish.gap_scores import gap_scores
from benchmarks.judges.fish.judge import AT_ONCE, FishJudge, chain_scores
from benchmarks.judges.fish.links import GROUPS, link_events, link_scores
from benchmarks.judges.fish.real import recordings
from benchmarks.judges.identities import identity_metrics
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.statistics.pooling import RatioOfMeans

_LINKED = "gaps of pieces of track that are linked"
_MADE = "gaps of pieces of track, of the group, that are linked"
_ALL = "gaps of pieces of track, of the group"


def _mean(
    name: str,
    words: str,
    conditions: str,
    defined_by: Callable[..., Any],
    *,
    row: str = "",
    high: float = 1,
    unit: str = "fraction",
    better: Better = "higher",
    source: str = OWN,
    ideal: float | None = None,
) -> Metric:
    """Return a metric that is the mean of the values >= 0 of a ``row``, by default of its own name."""
    quantity = Quantity(row or name, 0, high, conditions, source, (defined_by,))
    return Metric(name, words, unit, better, Mean(quantity), ideal=ideal)


def _gap_metrics(count: int) -> Iterator[Metric]:
    bridged = f"gaps of {count} frames cut into true tracks, that the method bridges"
    error = partial(
        _mean, conditions=bridged, defined_by=gap_scores, high=inf, unit="px", better="lower", source="paper C"
    )
    coverage = partial(_mean, conditions=f"{bridged} with a region", defined_by=gap_scores, ideal=0.95)
    inside = "true places inside the 95 % region"
    yield error(f"gap_error_{count}_px", f"error on the last of {count} lost frames")
    yield coverage(f"gap_coverage_{count}", f"{inside} then, {count} frames")
    yield error(f"gap_interpolation_error_{count}_px", f"mean error over {count} lost frames, far end known")
    yield coverage(f"gap_interpolation_coverage_{count}", f"{inside}, {count} frames, far end known")
    words = f"fish lost at once for {count} frames that get their own place at the end"
    yield _mean(f"successor_rate_{count}", words, f"fish lost together for {count} frames", gap_scores)


_GAPS = {count: tuple(_gap_metrics(count)) for count in GAP_FRAMES}


def _growth(count: int) -> Metric:
    later, first = (_GAPS[each][0].statistic.of[0] for each in (count, GAP_FRAMES[0]))
    words = f"error after {count} lost frames over that after {GAP_FRAMES[0]}"
    return Metric(f"gap_growth_{count}", words, "1", "lower", RatioOfMeans(later, first))


def _link_metrics(ending: str, when: str) -> Iterator[Metric]:
    for group, (gaps, _) in GROUPS.items():
        for name, words, conditions in (
            (f"link_precision_{group}", "right links of those made,", _MADE),
            (f"link_rate_{group}", "links made,", _ALL),
            (f"link_recall_{group}", "right links, of all gaps,", _ALL),
            (f"link_precision_{group}_of_90", "right ones of the surest links over 90 % of", _MADE),
        ):
            yield _mean(f"{name}{ending}", f"{words} {gaps}{when}", conditions, link_scores)


def _chain_metrics(ending: str, when: str) -> Iterator[Metric]:
    answers = "as answered at once" if when else "as revised at the end"
    frames = f"every frame, of the tracks {answers}"
    yield from identity_metrics("a body's length", "half a body's length", frames, chain_scores, ending, when)
    share = partial(_mean, conditions=frames, defined_by=chain_scores, better="lower")
    yield share(f"missed_rate{ending}", f"frames of fish without a track{when}")
    yield share(f"false_rate{ending}", f"frames of tracks on no fish, per frame of a fish{when}", high=inf)


_NOW = AT_ONCE, ", as answered at once"


def _describe(events: Sequence[dict[str, Any]]) -> str:
    lengths = sorted(event["length_frames"] for event in events)
    if not lengths:
        return "no gaps"
    crossing = sum(event["crosses"] for event in events)
    return (
        f"{counted(len(lengths), 'gap')} of {lengths_text(lengths)}, half of them below "
        f"{lengths[len(lengths) // 2] + 1}; in {crossing} fish cross"
    )


FISH = Suite(
    name="fish",
    edition=2,
    summary="fish in a tank from above: are lost pieces of track bridged, and does every fish keep its name?",
    scenes=(Scene("fish-tank", tuned_on=TuningEpisodes(seeds=range(300, 302), fresh_presets=("standard", "hard"))),),
    preset="standard",
    quick_preset="quick",
    judge=FishJudge,
    metrics=(
        *_chain_metrics("", ""),
        *_link_metrics("", ""),
        *(metric for of_count in _GAPS.values() for metric in of_count),
        *(_growth(count) for count in GAP_FRAMES[1:]),
        *_chain_metrics(*_NOW),
        *_link_metrics(*_NOW),
        *SPEED,
    ),
    headline=(
        "hota",
        "idf1",
        "link_precision_50",
        "link_rate_50",
        "link_precision_200",
        *(f"gap_error_{count}_px" for count in GAP_FRAMES),
        "gap_interpolation_error_50_px",
        "frames_per_s",
    ),
    compared=(
        "hota",
        "idf1",
        f"hota{AT_ONCE}",
        f"idf1{AT_ONCE}",
        "link_precision_50_of_90",
        *(f"gap_error_{count}_px" for count in GAP_FRAMES),
        *(f"gap_interpolation_error_{count}_px" for count in GAP_FRAMES),
    ),
    # Methods that only bridge gaps have neither identities nor HOTA: they can better the error after a gap, or in it.
    tuned_for={"idf1": 1.0, "hota": 1.0, "gap_error_50_px": -0.001, "gap_interpolation_error_50_px": -0.001},
    events=EventWords(
        name="gaps",
        key="event",
        tests={
            "up to 10 frames": lambda event: bool(event["length_frames"] <= 10),
            "11 to 50 frames": lambda event: bool(10 < event["length_frames"] <= 50),
            "more than 50 frames": lambda event: bool(event["length_frames"] > 50),
            "fish cross": lambda event: bool(event["crosses"]),
            "no fish cross": lambda event: not event["crosses"],
            "two fish": lambda event: bool(event["fish_count"] <= 2),
            "three or more fish": lambda event: bool(event["fish_count"] > 2),
        },
        describe=_describe,
        compared=(
            _mean("link_precision", "right links of those made", _LINKED, link_events, row="link_right"),
            _mean("link_rate", "links made", "every gap of pieces of track", link_events, row="link_made"),
        ),
    ),
    silence="no track",
    controller=None,
    follows_many=True,
    recordings=recordings,
)
register_suite(FISH)
