"""A controller's parameters may change between two pictures, as in an env's action mode ``parameters``."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.fakes_scenario import FAKE_TOWN
from trackers.controllers.catalogue import controllers
from trackers.types import Estimate

NOTHING = Estimate(np.full(2, np.nan), in_view_probability=0.0)
ENTRIES = [entry for carrier in ("helicopter", "robot") for entry in controllers(carrier).values() if entry.tunables()]


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: f"{entry.carrier}-{entry.name}")
def test_a_controller_with_changed_parameters_is_like_one_created_with_them(entry):
    setting = entry.parameters(**{name: field.metadata["high"] for name, field in entry.tunables().items()})
    changed, made, other = entry.create(), entry.controller(setting), entry.create()
    changed.parameters = setting
    assert changed.parameters == made.parameters != other.parameters
    episode = FAKE_TOWN.episode("tiny-loop", 0)
    frame = episode.step()
    in_view = Estimate(np.array([150.0, 20.0]), np.array([140.0, 10.0, 160.0, 30.0]), in_view_probability=1.0)
    commands = []
    for k in range(60):
        estimate = in_view if k < 3 else NOTHING
        ours, theirs, unset = (each.command(frame.observation, estimate) for each in (changed, made, other))
        assert dataclasses.astuple(ours) == dataclasses.astuple(theirs)
        commands.append((ours, unset))
        frame = episode.step(ours)
    assert any(ours != unset for ours, unset in commands)
