"""A trained policy as a controller of the suite ``follow``, in the world of arithmetic."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.experiment import run
from benchmarks.records import read_rows
from scenarios.road_town.flight import HELICOPTER
from tests.benchmarks.test_follow_run import TINY, TRACKERS, _fake_suite  # noqa: F401
from trackers.kernels.belief_features import FEATURES
from trackers.policy_file import Policy, save_policy


def policy(bias: float) -> Policy:
    """Return a policy that flies forward at the same share of full speed, whatever it is told."""
    weights = np.zeros((len(HELICOPTER.axes), len(FEATURES)), np.float32)
    return Policy(
        env="frameout/RoadTownFollow-v1",
        carrier=HELICOPTER,
        tracker="fake_knowing",
        base=None,
        correction_share=0.5,
        corrects="always",
        features=FEATURES,
        hidden="tanh",
        output="clip",
        weights=(weights,),
        biases=(np.array([bias, 0, 0, 0], np.float32),),
    )


def test_another_content_of_a_policys_file_is_run_anew(tmp_path: Path) -> None:
    file = save_policy(policy(0.1), tmp_path / "mine.json")
    experiment = replace(TINY, controllers=(f"policy:{file}", "hold"), trackers=TRACKERS[:1], seeds=range(1))
    out = tmp_path / "out"
    assert run(experiment, out).episodes == 2
    assert run(experiment, out).episodes == 0
    efforts = [row["value"] for row in read_rows(out) if row["metric"] == "effort" and row["role"] == "policy"]
    assert efforts == [pytest.approx(0.05, abs=0.001)]
    save_policy(policy(0.2), file)
    again = run(experiment, out)
    assert (again.resumed, again.episodes) == (1, 1)
    assert (read_rows(out)[0]["role"], "policy" in read_rows(out)[0]["versions"]) == ("baseline", False)
