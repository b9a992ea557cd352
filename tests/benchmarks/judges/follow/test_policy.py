"""Policies as controllers of the suite ``follow``, and envs with its scores, in the world of arithmetic."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.contract.rows import read_rows
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.reward import Reward
from scenarios.road_town.flight import HELICOPTER
from tests.benchmarks.judges.follow.test_run import TINY, TRACKERS, _fake_suite
from tests.benchmarks.named import run_named as run
from tests.fakes_policy import made_up_policy
from trackers.belief.features import FEATURES
from trackers.controllers.policy import Policy, save_policy

# A fixture that every test here uses.
__all__ = ["_fake_suite"]


def forward_policy(share: float) -> Policy:
    """Return a policy that flies forward at the same share of full speed for every input."""
    weights = np.zeros((len(HELICOPTER.axes), len(FEATURES)), np.float32)
    return made_up_policy(HELICOPTER, [weights], [np.array([share, 0, 0, 0], np.float32)])


@pytest.mark.heavy
def test_another_content_of_a_policys_file_is_run_anew(tmp_path: Path) -> None:
    file = save_policy(forward_policy(0.1), tmp_path / "mine.json")
    experiment = replace(TINY, controllers=(f"policy:{file}", "hold"), trackers=TRACKERS[:1], seeds=range(1))
    out = tmp_path / "out"
    assert run(experiment, out).episodes == 2
    assert run(experiment, out).episodes == 0
    efforts = [row["value"] for row in read_rows(out) if row["metric"] == "effort" and row["role"] == "policy"]
    assert efforts == [pytest.approx(0.05, abs=0.001)]
    save_policy(forward_policy(0.2), file)
    again = run(experiment, out)
    assert (again.resumed, again.episodes) == (1, 1)
    assert (read_rows(out)[0]["role"], "policy" in read_rows(out)[0]["editions"]) == ("blind", False)


@pytest.mark.heavy
@pytest.mark.parametrize("link", ["prompt", "noisy"])
def test_an_env_lives_what_the_suite_judges(link: str, tmp_path: Path) -> None:
    """The same scenario, seed, tracker, controller and link are the same episode; rows have six places."""
    out = tmp_path / "out"
    run(replace(TINY, controllers=("centre",), trackers=TRACKERS[:1], seeds=range(3, 4), link=link), out)
    judged = {row["metric"]: row["value"] for row in read_rows(out) if row.get("event") is None}
    settings = {"preset": "tiny", "tracker": TRACKERS[0], "controller": "centre", "action": "correction", "link": link}
    with closing(FollowEnv(TINY.scenario, reward=Reward(effort=1.0), **settings)) as env:
        env.reset(options={"episode_seed": 3})
        told = []
        while not env.episode.is_over:
            told.append(env.step(np.zeros(4, np.float32))[4])
    assert np.mean([info["in_view"] for info in told]) == pytest.approx(judged["time_in_view"], abs=1e-6)
    assert -np.mean([info["reward_effort"] for info in told]) == pytest.approx(judged["effort"], abs=1e-6)
