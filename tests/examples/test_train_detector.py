"""The example runs from end to end, learns, repeats exactly, and reads boxes out of cells as it wrote them in."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest

from benchmarks.data.sets.data_set import DataSet

pytest.importorskip("torch", reason="torch is not installed")
pytest.importorskip("pycocotools", reason="pycocotools is not installed")
import torch
import train_detector
from detections import average_precision, cars_seen
from train_detector import detect, picture_and_goals, train

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.mark.heavy
def test_the_loss_falls_and_the_same_seed_repeats_it(town: DataSet) -> None:
    samples = town.samples(picture_and_goals)
    losses = train(samples, 30, seed=0)[1]
    assert sum(losses[-3:]) < 0.5 * sum(losses[:3])
    (model, first), (again, second) = (train(samples, 3, seed=0) for _ in range(2))
    assert first == second
    assert all(torch.equal(a, b) for a, b in zip(model.parameters(), again.parameters(), strict=True))
    assert train(samples, 1, seed=1)[1] != losses[:1]


@pytest.mark.heavy
def test_it_runs_and_prints_an_ap(
    town: DataSet, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(train_detector.__file__)
    monkeypatch.setattr(sys, "argv", [path, "--data", town.url, "--unseen", town.url, "--steps", "2"])
    runpy.run_path(path, run_name="__main__")
    found = re.fullmatch(r"AP (\d\.\d{3})\n", capsys.readouterr().out)
    assert found
    assert 0 <= float(found[1]) < 1
    assert len(Path(path).read_text().splitlines()) < 100


@pytest.mark.heavy
def test_boxes_come_out_of_cells_as_they_went_in(town: DataSet) -> None:
    pairs = []
    for frame in town:
        _, goals = picture_and_goals(frame)
        perfect = torch.cat([torch.logit(goals[:1], eps=1e-4), goals[2:]])
        pairs.append((cars_seen(frame), detect(lambda _, out=perfect: out[None], torch.empty(3, 1, 1)).numpy()))
    assert sum(len(truth) for truth, _ in pairs) > 20
    assert average_precision(pairs) > 0.99
