"""Policies that come with the package: one for each env, made by the command on its card."""

from __future__ import annotations

import dataclasses
import json
import shlex

import pytest
import tyro

from benchmarks.commands.train import Train
from scenarios import catalog
from scenarios.catalog import unversioned
from trackers.controllers.catalogue import controllers
from trackers.controllers.policy_file import load_policy, policy_path, shipped_policies

NAMES = shipped_policies()


def test_every_scene_without_pictures_has_one() -> None:
    own = (each for each in catalog.entries() if each.env_id and each.place.startswith("scenarios."))
    ours = {unversioned(each.env_id) for each in own if catalog.scenario(each.id).pictureless}
    assert sorted(unversioned(load_policy(name).env) for name in NAMES) == sorted(ours)


@pytest.mark.parametrize("name", NAMES)
def test_it_was_made_by_the_command_on_its_card(name: str) -> None:
    policy = load_policy(name)
    scenario, tracker = catalog.envs()[policy.env]
    carrier = catalog.scenario(scenario).carrier
    assert (policy.carrier, policy.tracker) == (carrier, tracker)
    assert controllers(carrier.name)[f"policy:{name}"].role == "policy"
    lines = policy_path(name).with_suffix(".md").read_text().splitlines()
    [command] = (line for line in lines if line.startswith("frameout train "))
    training = tyro.cli(Train, args=shlex.split(command)[2:]).training
    # Those that were made before ``--modules`` name none.
    assert {"modules": [], **policy.made["by"]} == json.loads(json.dumps(dataclasses.asdict(training)))
    assert policy.made["seconds"] < 45 * 60
    [judged] = (line for line in lines if line.startswith("frameout bench follow "))
    assert f"policy:{name}" in shlex.split(judged)
