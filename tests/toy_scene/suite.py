"""The suite ``toy-many``: are all crates of the yard found, and does each keep its identity?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.contract.metric import Metric, Quantity
from benchmarks.contract.rows import Row
from benchmarks.contract.suite import EventWords, Scene, Suite, add_scene, register_suite
from benchmarks.show.charts import Chart
from benchmarks.show.showing import Showing, register_showing
from benchmarks.statistics.bootstrap import intervals_of
from benchmarks.statistics.pooling import Median
from tests.toy_scene.judge import ManyJudge

FOUND = Metric("found_rate", "crates that are there and have a track on them", "fraction", "higher")
SWITCHES = Metric("identity_switches", "times that a crate's track is another one", "1", "lower")
OF_A_CRATE = Metric("crate_found_rate", "the same of a crate", "fraction", "higher")


def _describe(stays: Sequence[dict[str, Any]]) -> str:
    return f"{len(stays)} crates, {sum(stay['length_frames'] for stay in stays)} times there"


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return the share found of each tracker."""
    shares = {name: {name: share} for name, share in intervals_of(FOUND.statistic, drawn).items()}
    return [Chart(title="How many are found?", words="", lines=shares, x_label="found", x_scale="share")]


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
            Metric("position_error_px", "of crates that are there, at most 6", "px", "lower"),
            Metric("false_tracks", "tracks on no crate, of a frame", "1", "lower"),
            Metric("frames_per_s", "frames a second on one core", "1/s", "higher", Median(Quantity("frames_per_s"))),
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
    )
)
register_showing("toy-many", Showing("Are all of them found?", charts))
add_scene("follow", Scene("toy-yard", "toy-many", ("warm_bodies",)))
