"""A policy is loaded as it was saved and steers by its network; other files are refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fakes_policy import random_policy
from trackers.belief.features import FEATURES, FeatureFilter, command_of
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.policy import Policy, load_policy, save_policy
from trackers.types import CameraCommand, CameraModel, Carrier, CommandAxis, EgoPose, Estimate, Observation

CARRIER = Carrier(
    "helicopter", (CommandAxis("forward_mps", 25.0, 40.0), CommandAxis("yaw_rate_rad_s", 1.0, 2.0)), "down"
)


def observation(time_s: float) -> Observation:
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[2, 3] = 50.0
    return Observation(np.zeros((48, 64, 3), np.uint8), time_s, CameraModel(64, 48, 70.0), ego=EgoPose(T))


def arrays_of(policy: Policy) -> list[NDArray[np.float32]]:
    return [policy.mean, policy.deviation, *policy.weights, *policy.biases, *policy.cells]


@pytest.mark.parametrize("cells", [0, 3])
def test_it_comes_back_as_it_was(cells: int, tmp_path: Path) -> None:
    saved = random_policy(CARRIER, cells=cells)
    path = save_policy(saved, tmp_path / "mine.json")
    loaded = load_policy(str(path))
    for ours, theirs in zip(arrays_of(saved), arrays_of(loaded), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    none: dict[str, Any] = {"weights": (), "biases": (), "cells": (), "mean": None, "deviation": None}
    assert replace(loaded, **none) == replace(saved, **none)
    assert load_policy(str(tmp_path / "mine.safetensors")).carrier == CARRIER


def test_its_action_is_the_networks() -> None:
    given = random_policy(CARRIER)
    features = np.linspace(-1, 1, len(FEATURES), dtype=np.float32)
    hidden = np.tanh(given.weights[0] @ features + given.biases[0])
    wanted = given.weights[1] @ hidden + given.biases[1]
    np.testing.assert_allclose(given.action(features[None], given.new_memory(1))[0], np.clip(wanted, -1, 1), rtol=1e-5)
    squashed = replace(given, output="tanh").action(features[None], given.new_memory(1))[0]
    np.testing.assert_allclose(squashed, np.tanh(wanted), rtol=1e-5)


def test_its_memory_is_pytorch_s() -> None:
    torch = pytest.importorskip("torch")
    given = random_policy(CARRIER, cells=3)
    lstm = torch.nn.LSTM(len(FEATURES), 3, batch_first=True)
    with torch.no_grad():
        for name, values in zip(("weight_ih_l0", "weight_hh_l0", "bias_ih_l0"), given.cells, strict=True):
            getattr(lstm, name).copy_(torch.from_numpy(values))
        lstm.bias_hh_l0.zero_()
    seen = np.random.default_rng(1).uniform(-1, 1, (2, 5, len(FEATURES))).astype(np.float32)
    wanted = lstm(torch.from_numpy(seen))[0].detach().numpy()
    memory = given.new_memory(2)
    for k in range(5):
        actions = given.action(seen[:, k], memory)
        np.testing.assert_allclose(memory[0], wanted[:, k], atol=1e-6)
        without = replace(given, cells=(), mean=np.zeros(3, np.float32), deviation=np.ones(3, np.float32))
        np.testing.assert_allclose(actions, without.action(wanted[:, k], without.new_memory(2)), atol=1e-5)


def test_it_steers_as_a_controller(tmp_path: Path) -> None:
    path = save_policy(random_policy(CARRIER), tmp_path / "mine.json")
    entry = controller_entry(f"policy:{path}", "helicopter")
    assert entry.role == "policy"
    first, second = entry.create(), entry.create()
    estimate = Estimate(np.array([40.0, 20.0]), in_view_probability=0.9)
    given = [first.command(observation(t / 15), estimate) for t in range(3)]
    assert given == [second.command(observation(t / 15), estimate) for t in range(3)]
    assert given[0] != CameraCommand()


def test_its_input_is_standardised_and_clipped_as_in_training() -> None:
    given = random_policy(CARRIER)
    features = np.linspace(-1, 1, len(FEATURES), dtype=np.float32)
    moved = replace(given, mean=features - np.float32(0.02), deviation=np.full_like(features, 0.001))
    clipped = np.full((1, len(FEATURES)), 10.0, np.float32)
    np.testing.assert_allclose(
        moved.action(features[None], moved.new_memory(1)), given.action(clipped, given.new_memory(1)), rtol=1e-5
    )


def test_it_sees_what_has_changed_and_holds_its_action(tmp_path: Path) -> None:
    """Its commands, computed here from the features of every picture."""
    policy = random_policy(CARRIER, history=2, action_repeat=3)
    controller = controller_entry(f"policy:{save_policy(policy, tmp_path / 'mine.json')}", "helicopter").create()
    features, seen, given = FeatureFilter(CARRIER), list[NDArray[np.float32]](), CameraCommand()
    wanted = given
    for t in range(7):
        estimate = Estimate(np.array([40.0 + t * t, 20.0 - t]), in_view_probability=0.9)
        seen.append(features.update(observation(t / 15), estimate, given))
        before = [seen[max(t - back, 0)] for back in (1, 2)]
        if t % 3 == 0:
            numbers = np.concatenate([seen[t], *(seen[t] - each for each in before)])
            wanted = command_of(CARRIER, policy.action(numbers[None], policy.new_memory(1))[0])
        given = controller.command(observation(t / 15), estimate)
        assert given == wanted


@pytest.mark.parametrize("corrects", ["always", "unseen"])
def test_it_corrects_another_controller(tmp_path: Path, corrects: str) -> None:
    base = {"controller": "hold", "parameters": {}}
    path = save_policy(replace(random_policy(CARRIER), base=base, corrects=corrects), tmp_path / "mine.json")
    controller = controller_entry(f"policy:{path}", "helicopter").create()
    seen = controller.command(observation(0.0), Estimate(np.array([40.0, 20.0]), in_view_probability=0.9))
    unseen = controller.command(observation(0.1), Estimate(np.array([40.0, 20.0]), in_view_probability=0.1))
    assert (seen == CameraCommand()) == (corrects == "unseen")
    assert unseen != CameraCommand()
    assert abs(unseen.forward_mps) <= 0.5 * 25.0


def test_a_policy_for_another_carrier_is_refused(tmp_path: Path) -> None:
    path = save_policy(random_policy(CARRIER), tmp_path / "mine.json")
    with pytest.raises(ValueError, match=r"controller: expected a policy for a robot, got .* for a helicopter"):
        controller_entry(f"policy:{path}", "robot")


def test_files_that_are_no_policies_are_refused(tmp_path: Path) -> None:
    path = save_policy(random_policy(CARRIER), tmp_path / "mine.json")
    with pytest.raises(ValueError, match=r"policy: expected a file that can be read, got .*missing.json"):
        load_policy(str(tmp_path / "missing.json"))
    with pytest.raises(ValueError, match=r"got '.*missing.zip', whose JSON file would be '.*missing.json': No such"):
        load_policy(str(tmp_path / "missing.zip"))
    with pytest.raises(ValueError, match=r"policy: expected a file, got ''"):
        load_policy("")
    alone = tmp_path / "alone.json"
    alone.write_bytes(path.read_bytes())
    with pytest.raises(ValueError, match=r"got '.*alone.json': No such file or directory of .*alone.safetensors"):
        load_policy(str(alone))
    document = json.loads(path.read_text())
    wrong: list[dict[str, Any]] = [
        {"format": 1},
        {"history": 1},
        {"history": -1},
        {"action_repeat": 0},
        {"layers": 3},
        {"layers": 0},
        {"features": ["one"]},
        {"carrier": None},
    ]
    wrong += [{"hidden": "gelu"}, {"output": "sign"}, {"corrects": "never"}, {"correction_share": 0}]
    wrong += [{"weights_sha256": "0"}, {"cells": 3}]
    for change in wrong:
        path.write_text(json.dumps(document | change))
        with pytest.raises(ValueError, match="policy: expected a policy of format 2, got"):
            load_policy(str(path))
    path.write_text(json.dumps(document))
    path.with_suffix(".safetensors").write_bytes(b"torn")
    with pytest.raises(ValueError, match="policy: expected a policy of format 2, got"):
        load_policy(str(path))


@pytest.mark.parametrize("part", [0, 1, 2])
@pytest.mark.parametrize("values", [np.zeros(()), np.zeros((2, 2)), "not finite"])
def test_cells_that_do_not_fit_are_refused(part: int, values: Any, tmp_path: Path) -> None:
    good = random_policy(CARRIER, cells=3)
    cells = list(good.cells)
    cells[part] = np.full_like(cells[part], np.nan) if isinstance(values, str) else values.astype(np.float32)
    path = save_policy(replace(good, cells=tuple(cells)), tmp_path / "mine.json")
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document | {"cells": 3}))
    with pytest.raises(ValueError, match=r"policy: expected a policy of format 2, got .*: cells of finite numbers"):
        load_policy(str(path))
