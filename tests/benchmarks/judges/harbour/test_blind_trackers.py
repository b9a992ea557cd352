"""In the ranking figure of the harbour trackers without pictures are far below the paper's method."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.run.selection import trackers_of
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run

BLIND, WRITTEN = ("harbour_blind", "harbour_posts"), "eigen_swarm"
SEEDS = {"standard": range(3), "hard": range(1), "paper-d": range(1)}


def test_all_blind_trackers_are_examined() -> None:
    roles = {name: each.role for name, each in trackers_of("harbour").items()}
    assert {name for name, role in roles.items() if role == "blind"} == set(BLIND)
    assert {name for name, role in roles.items() if role == "as-written"} == {WRITTEN}


@pytest.mark.heavy
@pytest.mark.parametrize("preset", SEEDS)
def test_who_sees_nothing_has_less_than_half_the_froc_area_of_the_method_as_written(
    preset: str, tmp_path: Path
) -> None:
    outcome = run(Experiment("harbour", "harbour-v1", (preset,), (*BLIND, WRITTEN), SEEDS[preset], workers=0), tmp_path)
    areas = {each["tracker"]: each["mean"] for each in outcome.summary if each["metric"] == "froc_area_1_100"}
    print(f"{preset}, froc_area_1_100: {areas}")
    assert max(areas[name] for name in BLIND) < 0.5 * areas[WRITTEN]
