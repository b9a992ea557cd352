"""Paper experiment D: intruders in a harbour, found by sets of particles on a background of eigenspaces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.contract.metric import Metric, Quantity
from benchmarks.contract.rows import Row
from benchmarks.contract.suite import suite
from benchmarks.papers.claims import Claim
from benchmarks.papers.experiment import Plots
from benchmarks.papers.robustness import Robustness, scaled
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.show.palette import line_styles
from benchmarks.show.plots import plot_of
from benchmarks.show.showing import showing_of
from benchmarks.statistics.pooling import Median
from benchmarks.statistics.summary import grouped
from scenarios.scenario import RendererName
from trackers import registry
from trackers.eigen_swarm.tracker import EigenSwarmParameters

_WRITTEN, _OURS = "eigen_swarm", "harbour_watch"
_FOUND = {"person": (12, 15), "car": (2, 3), "boat": (1, 1)}
"""The paper's table 1: found, and how many came."""
_SIZES_M = {
    "person": {"width": (0.7, 0.5), "depth": (2.3, 0.5), "height": (1.8, 1.6)},
    "car": {"width": (2.4, 1.7), "depth": (2.9, 4.0), "height": (2.5, 1.6)},
}
"""The paper's table 2: estimated, and real, of one person and one car."""
_AS_PRINTED = EigenSwarmParameters()
_POINTS, _SHARE = 0.08, 1 / 3
"""How far from the paper's share found, and from its sizes as a share of them, still agrees: our choice."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HarbourExperiment(TrackerExperiment):
    """See ``TrackerExperiment``. Sizes are those of the tracks that the paper counts."""

    def metric(self, name: str) -> Metric:
        """See ``PaperExperiment``: a metric of the suite, or the median size of a class, ``region_width_m person``."""
        row, _, kind = name.partition(" ")
        if kind:
            return Metric(name, f"{row} of class {kind}", "m", "lower", Median(Quantity(row), kind=kind))
        return suite(self.suite).metric(name)

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots:
        """See ``PaperExperiment``: one visit with both methods, and the suite's figures."""
        condition = self.condition(renderer)
        drawn = {name: grouped(rows)[condition][name] for name in self.trackers}
        self.keep_picture(out, condition, drawn)
        styles = line_styles([(name, registry.entry(name).role) for name in self.trackers])
        plots = [plot_of(chart, styles) for chart in showing_of(suite(self.suite)).charts(drawn)]
        return Plots("What the paper could not measure", {f"{plot.title} {plot.words}": plot.svg for plot in plots})


def _written() -> Iterator[Claim]:
    counted = "tracked four times running: its region overlaps the intruder in the picture; nothing is subtracted"
    found, came = (sum(each) for each in zip(*_FOUND.values(), strict=True))
    words = f"{found} of {came} intruders found, {found / came:.1%}"
    yield Claim(
        "paper_detection_rate", counted, words, "within", found / came, tracker=_WRITTEN, tolerance=_POINTS, fitted=True
    )
    for kind, (right, number) in _FOUND.items():
        words = f"{kind}: {right} of {number}, {right / number:.1%}"
        yield Claim(f"paper_detection_rate_{kind}", f"the same, class {kind}", words, tracker=_WRITTEN)
    for kind, sizes in _SIZES_M.items():
        for name, (said_m, real_m) in sizes.items():
            metric, of = f"region_{name}_m {kind}", f"{name} of a {kind}, median over those found"
            words, tolerance = f"{said_m} m, real {real_m} m", round(_SHARE * said_m, 2)
            yield Claim(metric, of, words, "within", said_m, tracker=_WRITTEN, tolerance=tolerance)
    yield Claim(
        "tide_share",
        "of the false alarms those by moored boats and their ropes",
        "very many false alarms, most by moored boats that move with the tide; not measured",
        "more than",
        0.5,
        tracker=_WRITTEN,
    )


def _beside() -> Iterator[Claim]:
    metrics = {
        "false_alarms_per_hour": "identities on nothing four frames running",
        "detection_rate": "of those that can be seen: within 3 m over the ground too, one to one, chance taken off",
        "chance_rate": "found by tracks on nothing beside the truth of another time",
        "beyond_m": "how far behind the intruder a track lies as the camera sees it",
        "detection_rate_at_1": "the same, with at most one false alarm an hour",
        "froc_area_01_10": "the same, mean over the log of the false alarms, 0.1 to 10 an hour",
        "froc_area_1_100": "the same, 1 to 100 an hour",
        "average_precision": "average precision of boxes in single pictures, as of COCO",
    }
    for tracker in (_WRITTEN, _OURS):
        for metric, counted in metrics.items():
            yield Claim(metric, counted, tracker=tracker)
    yield Claim("paper_detection_rate", "counted as in the paper", tracker=_OURS)
    yield Claim(
        "froc_area_1_100",
        f"the same, minus that of {_OURS} on the same episodes",
        "not in the paper; ours is to find more",
        "interval below",
        tracker=_WRITTEN,
        minus=_OURS,
    )
    yield Claim(
        "detection_rate_at_a_tenth",
        f"detection rate with at most a tenth of the false alarms that {_WRITTEN} raises, minus what that finds",
        "not in the paper; ours is to find more",
        "more than",
        0.0,
        tracker=_OURS,
        minus=_WRITTEN,
    )


EXPERIMENT = HarbourExperiment(
    name="D",
    title="Paper D: people, cars and boats in a harbour, seen by a thermal camera",
    setting="A camera of 384 × 288 pixels, 20 m high, watches 90 × 33 × 6 m about 100 m away, for 70 minutes from six "
    "in the morning, with a picture every two seconds; 400 pictures show the harbour without intruders, on three days "
    "that differ in sun, weather and tide: clear and calm, half covered and windy a week later, overcast with rain "
    "eight days after that, with low water at the hours of high water of the day before it. 15 people, 3 cars and a "
    "boat come; who gets out of a car counts anew. One of the cars has stood since before and is as warm as the yard "
    "about it; another car stood in its bay on two of the three days. The paper's parameters are as printed. The "
    "paper has one such recording; here each seed is another morning.",
    fitted="the scene's contrasts, the weather of the morning (overcast and calm), the boat at a buoy, the "
    "two cars on the apron, and what the paper leaves open of its method (share of variance, noise, patience) were set "
    "on development seeds so that it finds about as many as in the paper, while the three days before were overcast as "
    "well and the standing car had a contrast; with the days as they are now nothing was set anew.",
    notes=(
        "Depth and height: from 20 m above, a place 100 m away is seen along a line that falls by only one metre in "
        "five. All particles on it fall into one block of 8 × 8 pixels of the enlarged picture, 0.5 m wide there, and "
        "are equally likely wherever they lie on it inside the volume: a cloud is tens of metres long and metres high "
        "whatever stands there, and its depth is what ε = 0.1 makes of that length.",
        "The centre of such a cloud is the middle of that piece of the line, not the object: within 3 m over the "
        "ground fewer are found than overlap in the picture.",
    ),
    suite="harbour",
    scenario="harbour-v1",
    preset="paper-d",
    trackers=(_WRITTEN, _OURS),
    beside=("eigen_swarm_learnt_confidence", "harbour_mog2_tuned", "harbour_blind"),
    claims=(*_written(), *_beside()),
    robustness=Robustness(
        trackers=(_WRITTEN,),
        metrics=("paper_detection_rate", "detection_rate", "false_alarms_per_hour"),
        settings=scaled(
            "both thresholds",
            (0.5, 0.8, 1.25, 2.0),
            threshold_few=_AS_PRINTED.threshold_few,
            threshold_many=_AS_PRINTED.threshold_many,
        ),
        rates={
            "half as many people": {"people": 8},
            "twice as many people": {"people": 30},
            "two boats at buoys in place of one": {"buoys": 2},
        },
        words="The thresholds are those of the distance from the background in a block, which the paper prints; both "
        "are varied by the same factor.",
        episodes=2,
    ),
    seeds=range(10_000, 10_010),
)
