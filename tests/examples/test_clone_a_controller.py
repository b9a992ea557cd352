"""The example clones what can be cloned, repeats exactly, and runs from end to end."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.learning.rollouts.making import make
from benchmarks.learning.rollouts.request import Rollouts
from scenarios import catalog
from tests.benchmarks.learning.rollouts.painted_town import FRAMES, made

pytest.importorskip("torch", reason="torch is not installed")
import clone_a_controller
import torch
from clone_a_controller import HISTORY, IGNORED, samples_of, scale_of, train

from trackers.belief.features import FEATURES


def test_samples_are_features_and_their_changes_and_the_commands_are_not_looked_at(tmp_path: Path) -> None:
    folder = made(tmp_path / "set", pictures="none")
    seen, done = samples_of(folder)
    table = pd.read_parquet(folder / "data").dropna(subset="action")
    features = np.stack(table["observation.track"].to_list())
    np.testing.assert_array_equal(seen[:, : len(FEATURES)], features)
    np.testing.assert_array_equal(done, np.stack(table["action"].to_list()))
    blocks = seen.reshape(len(seen), 1 + HISTORY, len(FEATURES))
    for back in range(1, 1 + HISTORY):
        steps = FRAMES - 1
        for number in range(len(seen)):
            before = max(number - back, number - number % steps)
            np.testing.assert_array_equal(blocks[number, back], features[number] - features[before])
    mean, deviation = scale_of(seen)
    ignored = (deviation == IGNORED).reshape(1 + HISTORY, len(FEATURES))
    assert (ignored == [name.startswith("command_") for name in FEATURES]).all()
    assert np.abs((seen - mean) / deviation)[:, ignored.ravel()].max() < 1e-5


def test_a_rule_is_learnt_and_the_same_seed_repeats_it() -> None:
    rng = np.random.default_rng(0)
    seen = rng.normal(size=(500, 6)).astype(np.float32)
    done = np.stack([np.tanh(seen[:, 0]), 0.5 * seen[:, 1] * (seen[:, 2] > 0)], axis=1).astype(np.float32)
    network, error = train(seen, done, 250, seed=0)
    assert error < 0.2 * done.var()
    again, same = train(seen, done, 250, seed=0)
    assert error == same
    assert all(torch.equal(a, b) for a, b in zip(network.parameters(), again.parameters(), strict=True))
    assert train(seen, done, 250, seed=1)[1] != error


@pytest.mark.heavy
def test_it_runs_and_prints_how_the_clone_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    order = Rollouts(catalog.DEFAULT_ENV, (0, 1), "parquet", "omniscient", "none", tracker="hold", preset="quick")
    make(order, tmp_path / "teacher", 0, lambda done, of: None)
    path = str(clone_a_controller.__file__)
    words = [str(tmp_path / "teacher"), "--out", str(tmp_path / "clone"), "--episodes", "1", "--steps", "200"]
    monkeypatch.setattr(sys, "argv", [path, *words])
    runpy.run_path(path, run_name="__main__")
    told = capsys.readouterr().out
    assert re.match(r"149 steps of omniscient; mean squared error 0\.\d{4}\n", told)
    seen = {line.split()[0]: float(line.split()[-1]) for line in told.splitlines()[3:]}
    assert list(seen) == ["omniscient", "reentry", f"policy:{tmp_path / 'clone' / 'clone.json'}"]
    assert seen["omniscient"] > 0.9, "the last column is the time seen"
    assert len(Path(path).read_text().splitlines()) < 100
