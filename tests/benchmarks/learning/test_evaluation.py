"""A training's policies are evaluated with pictures on the way, by the command that users run."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.contract.rows import read_rows
from benchmarks.learning import evaluation
from benchmarks.learning.evaluation import JUDGED, Evaluation, Evaluations, judging_command
from benchmarks.learning.settings import Training
from scenarios import catalog
from trackers.controllers.catalogue import controllers

TINY = Training(env="frameout/RoadTownFollow-v3", preset="quick", steps=4096, envs=4, episodes=2, episode_steps=40)


@pytest.mark.heavy
def test_policies_are_evaluated_on_the_way_and_at_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("stable_baselines3")
    from benchmarks.learning.training import train

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(evaluation, "JUDGED", range(9_999, 10_000))
    told: list[Evaluation] = []
    path = train(TINY, tmp_path / "a", lambda each: told.append(each) if isinstance(each, Evaluation) else None)
    assert [each.steps for each in told] == [2048, 4096]
    rows = read_rows(tmp_path / "a" / "judged")
    names = {"reentry": "reentry", f"policy:{tmp_path}/a/policies/2048.json": "first", f"policy:{path}": "last"}
    seen = {names[str(row["controller"])]: row["value"] for row in rows if row["metric"] == "time_seen"}
    assert seen.keys() == {"reentry", "first", "last"}
    for each, name in zip(told, ("first", "last"), strict=True):
        assert each.time_seen == seen[name]
        assert each.controller == "reentry"
        assert each.difference == pytest.approx(float(str(seen[name])) - float(str(seen["reentry"])))


def test_a_failing_evaluation_is_named_and_one_that_runs_can_be_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluation, "_words", lambda *_: ["bench", "follow", "--preset", "no such"])
    failing = Evaluations(TINY, tmp_path)
    failing.begin(tmp_path / "policy.json", 4)
    with pytest.raises(ChildProcessError, match=r"evaluation: it ended with status 2: .*preset: expected"):
        failing.ended(wait=True)
    ended = Evaluations(TINY, tmp_path)
    ended.begin(tmp_path / "policy.json", 4)
    ended.stop()
    assert ended.ended(wait=True) == []


def test_every_policy_is_judged_on_few_development_episodes_beside_a_controller_of_its_carrier() -> None:
    assert 2 <= len(JUDGED) <= 8
    assert JUDGED.stop <= 10_000
    for controller, beside in (("none", "centre"), ("hold", "hold")):
        for env in ("frameout/StereoFollow-v3", "frameout/HarbourFollow-v1"):
            mine = Training(env, controller=controller, modules=("a.py",), env_kwargs={"link": "delayed"})
            assert beside in controllers(catalog.scenario(mine.scenario).carrier.name)
            command = judging_command(mine, Path("p.json"))
            assert f" --controllers policy:p.json {beside} " in command
            assert command.endswith("--link delayed --modules a.py")
