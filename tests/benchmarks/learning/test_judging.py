"""``frameout train`` tells how the training goes, and the command it names at the end judges the policy."""

from __future__ import annotations

import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.learning import judging
from benchmarks.learning.judging import SEEDS, Judging
from benchmarks.learning.training import Training
from benchmarks.run.workers import cores
from scenarios import catalog
from tests.scenarios.envs import stand_in
from trackers.controllers.catalogue import controllers

pytest.importorskip("stable_baselines3")
import gymnasium as gym

from benchmarks.learning.vector_adapter import GymnasiumVecEnv

ENV = "frameout/RoadTownFollow-v2"
STEPS = 2 * 128


@pytest.mark.heavy
def test_what_is_told_on_the_way_and_the_command_at_the_end_which_runs_word_for_word(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a world without a renderer, with one episode of the four, in a folder whose name a shell would split."""
    monkeypatch.chdir(tmp_path)
    place = f"{stand_in.__name__}:FLOWN"
    scenes = (replace(each, place=place) if each.id == stand_in.FLOWN.id else each for each in catalog._ENTRIES)
    monkeypatch.setattr(catalog, "_ENTRIES", tuple(scenes))
    monkeypatch.setattr(judging, "SEEDS", range(9_999, 10_000))
    # Measured by a function with tests of its own.
    monkeypatch.setattr(judging, "seconds_of_episode", lambda job: 70.0)
    words = f"train frameout/RoadTownFollow-v2 --pictures --preset tiny --tracker fake_knowing --steps {STEPS}".split()
    assert main([*words, "--envs", "1", "--out", "a folder"]) == 0
    out, err = capsys.readouterr()
    lines = re.findall(r"([\d,]+) steps: episode reward (\S+), in view (\d+)% of the time, ([\d,]+) steps/s", err)
    assert lines[-1][0] == f"{STEPS:,}"
    for _, reward, share, rate in lines:
        assert -100.0 < float(reward) <= 59 * 1.2
        assert 0 <= int(share) <= 100
        assert int(rate.replace(",", "")) > 0
    first, told, command, minutes = out.splitlines()
    assert (first, told) == ("policy: a folder/policy.json", "judge it beside reentry, with pictures:")
    assert re.fullmatch(rf"it takes about [1-9] min on {cores(None)} idle cores", minutes)
    program, *named = shlex.split(command)
    assert program == "frameout"
    assert main([*named, "--workers", "0"]) == 0
    rows = read_rows(tmp_path / "a folder" / "judged")
    assert {row["controller"] for row in rows} == {"policy:a folder/policy.json", "reentry"}
    assert {row["seed"] for row in rows} == {9_999}
    assert json.loads((tmp_path / "a folder" / "judged" / "comparisons.json").read_text()) is not None


def test_the_episodes_are_of_development_and_few() -> None:
    assert 2 <= len(SEEDS) <= 8
    assert SEEDS.stop <= 10_000


@pytest.mark.parametrize("controller", ["none", "hold"])
def test_every_policy_is_compared_with_a_controller_of_its_carrier(controller: str) -> None:
    for env in ("frameout/StereoFollow-v2", "frameout/HarbourFollow-v1"):
        mine = Judging(Training(env, controller=controller, modules=("a.py",)), Path("p.json"))
        assert mine.controller in controllers(catalog.scenario(mine.training.scenario).carrier.name)
        assert mine.command.endswith("--modules a.py")


def test_minutes_are_those_of_the_rounds_on_all_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judging, "seconds_of_episode", lambda job: 40.0)
    for workers, rounds in ((1, 8), (3, 3), (16, 1)):
        monkeypatch.setattr(judging, "cores", lambda _, workers=workers: workers)
        assert Judging(Training(ENV), Path("p.json")).minutes() == math.ceil(rounds * 40 / 60)


def test_an_episode_s_reward_and_time_in_view_are_its_own_steps() -> None:
    """Summed here from a second env with the same seed; the step that ends an episode begins the next.

    The helicopter flies off, so that the target is out of view at the end and in view again at once.
    """
    options = {"pictures": False, "seeds": range(2), "preset": "quick", "max_episode_steps": 40}
    ours = GymnasiumVecEnv(gym.make_vec(ENV, 3, **options), 4, 0.01)
    theirs = gym.make_vec(ENV, 3, **options)
    ours.reset()
    theirs.reset(seed=4)
    rewards, seen = np.zeros(3), np.zeros(3)
    for step in range(1, 81):
        actions = np.array([[1, 1, 0, 0]] * 3, np.float32)
        *_, details = ours.step(actions)
        _, reward, _, truncated, infos = theirs.step(actions)
        rewards += reward
        seen += infos["final_info"]["in_view"] if step % 40 == 0 else infos["in_view"]
        assert truncated.all() == (step % 40 == 0)
        for k in range(3):
            if step % 40:
                assert "episode" not in details[k]
                continue
            episode = details[k]["episode"]
            assert episode["l"] == 40
            assert episode["r"] == pytest.approx(rewards[k])
            assert episode["in_view"] == pytest.approx(seen[k] / 40)
            assert not infos["final_info"]["in_view"][k]
            assert infos["in_view"][k]
            rewards[k] = seen[k] = 0.0
