"""The suite ``toy-many``: are all crates of the yard found, and does each keep its identity?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import EventWords, Metric, Scene, Suite, add_scene, register_suite
from benchmarks.show.dot_plot import plot_groups
from benchmarks.show.palette import LineStyle
from benchmarks.show.plots import Plot
from benchmarks.show.showing import Showing, register_showing
from benchmarks.statistics import pooling
from benchmarks.statistics.bootstrap import bootstrap_interval
from tests.toy_scene.judge import ManyJudge, ManySheet

FOUND = Metric("found_rate", "crates that are there and have a track on them", "fraction", "higher", ("found_rate",))
SWITCHES = Metric(
    "identity_switches", "times that a crate's track is another one", "1", "lower", ("identity_switches",)
)
OF_A_CRATE = Metric("crate_found_rate", "the same of a crate", "fraction", "higher", ("crate_found_rate",))


def _describe(stays: Sequence[dict[str, Any]]) -> str:
    return f"{len(stays)} crates, {sum(stay['length_frames'] for stay in stays)} times there"


def figures(drawn: Mapping[str, Sequence[Row]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    """Return the share found of each tracker."""
    pools = {name: pooling.pooled(rows, FOUND) for name, rows in drawn.items()}
    shares = {name: (pool.mean, *bootstrap_interval(pool)) for name, pool in pools.items() if pool is not None}
    svg = plot_groups({"all crates": shares}, styles, "found")
    return [Plot("How many are found?", "Dots: all episodes; bars: 95 % bootstrap over seeds.", svg)]


register_suite(
    Suite(
        name="toy-many",
        summary="warm crates under a thermal camera at rest: is each found, and does it keep its identity?",
        scenes=(Scene("toy-yard"),),
        preset="standard",
        quick_preset="quick",
        judge=ManyJudge,
        metrics=(
            FOUND,
            SWITCHES,
            Metric("position_error_px", "of crates that are there, at most 6", "px", "lower", ("position_error_px",)),
            Metric("false_tracks", "tracks on no crate, of a frame", "1", "lower", ("false_tracks",)),
            Metric("frames_per_s", "frames a second on one core", "1/s", "higher", ("frames_per_s",), "median"),
        ),
        headline=("found_rate", "identity_switches", "position_error_px", "false_tracks", "frames_per_s"),
        compared=("found_rate", "identity_switches"),
        tuned_for={"found_rate": 1.0, "identity_switches": -0.1},
        events=EventWords(
            name="stays",
            key="event",
            tests={"crates": lambda event: bool(event["kind"] == "crate")},
            compared=(OF_A_CRATE,),
            describe=_describe,
            episodes=(FOUND, SWITCHES),
        ),
        silence="no track; all crates that are there are missed",
        controller=None,
        follows_many=True,
        definitions={
            ManySheet.scores: (
                "found_rate",
                "position_error_px",
                "identity_switches",
                "false_tracks",
                "crate_found_rate",
            )
        },
    )
)
register_showing("toy-many", Showing("Are all of them found?", figures))
add_scene("follow", Scene("toy-yard", "toy-many", ("warm_bodies",)))
