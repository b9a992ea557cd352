"""Policies that ship are for their carriers, say how they were made, and correct the tuned controller."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from scenarios import catalog
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.learnt import FOLDER
from trackers.controllers.policy import load_policy

FILES = sorted(FOLDER.glob("*.json"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_is_the_carriers_controller_and_corrects_the_tuned_one(file: Path) -> None:
    policy, entry = load_policy(str(file)), controller_entry("learnt", file.stem)
    assert policy.carrier == catalog.scenario(catalog.envs()[policy.env][0]).carrier
    assert (policy.carrier.name, entry.role) == (file.stem, "policy")
    assert policy.base is not None
    base = controller_entry(policy.base["controller"], file.stem)
    assert policy.base["parameters"] == dataclasses.asdict(base.parameters())
    assert entry.create() is not None


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_has_a_card_with_the_command_of_its_training(file: Path) -> None:
    policy, card = load_policy(str(file)), file.with_suffix(".md").read_text()
    assert policy.made["by"]["env"] == policy.env
    assert f"`frameout train {policy.env}" in card
    assert f"seed {policy.made['by']['seed']}" in card


def test_there_are_some() -> None:
    assert len(FILES) >= 1
