"""The example learns, and its tracker reads what it has written."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.data_set import DataSet
from trackers import registry
from trackers.mosaic_graph.road_network import SeenGround

pytest.importorskip("torch", reason="torch is not installed")
import learn_roads
import torch
from learn_roads import LearntRoads, ground_and_road, main, train

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.mark.heavy
def test_pieces_of_ground_have_roads_and_say_nothing_where_nothing_is_seen(town: DataSet) -> None:
    torch.manual_seed(0)
    pieces = [ground_and_road(town[index]) for index in range(0, 120, 10)]
    grounds, goals = (torch.stack(each) for each in zip(*pieces, strict=True))
    assert (goals[grounds.sum(1) == 0] == -1).float().mean() > 0.99
    told = goals[goals >= 0]
    assert 0.05 < told.mean() < 0.6
    # Asphalt is greyer than lawns and roofs.
    spread = grounds.amax(1) - grounds.amin(1)
    assert spread[goals == 1].mean() < 0.8 * spread[goals == 0].mean()


@pytest.mark.heavy
def test_what_it_learns_is_written_and_read_back(town: DataSet, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    samples = town.samples(ground_and_road)
    losses = train(samples, 40, seed=0)[1]
    assert sum(losses[-5:]) < 0.8 * sum(losses[:5])
    weights = tmp_path / "weights.safetensors"
    main(town.url, weights, town.url, steps=40)
    found = re.search(r"IoU (\d\.\d+)", capsys.readouterr().out)
    assert found
    assert float(found[1]) > 0.3
    assert weights.stat().st_size < 2e6
    ground, goal = samples[40]
    rgb, seen = (255 * ground).byte().permute(1, 2, 0).numpy(), (ground.sum(0) > 0).numpy()
    found = LearntRoads(weights).probability(SeenGround(np.zeros(2), rgb[:-3], seen[:-3].astype(np.uint8), seen[:-3]))
    assert found.shape == (125, 128)
    judged = (goal.numpy() >= 0)[:-3] & seen[:-3]
    assert ((found > 0.5) == (goal.numpy()[:-3] == 1))[judged].mean() > 0.8


@pytest.mark.heavy
def test_the_tracker_follows_a_car(town: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    weights = tmp_path / "weights.safetensors"
    main(town.url, weights, steps=1)
    monkeypatch.setattr(learn_roads, "WEIGHTS", weights)
    tracker = registry.entry("learnt_roads").create(np.random.default_rng(0))
    frames = list(town.episode(3))[:12]
    tracker.initialise(frames[0].observation, frames[0].truth.box_xyxy[0])
    for frame in frames[1:]:
        assert np.isfinite(tracker.update(frame.observation).position_px).all()
