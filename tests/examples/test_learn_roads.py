"""The example learns, and writes what the tracker's network reads: both give the same answers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers, generate
from benchmarks.data.sets.request import Request
from trackers.mosaic_graph.learnt_roads import RoadNetwork

pytest.importorskip("torch", reason="torch is not installed")
import learn_roads
import torch
from learn_roads import ground_and_road, main, train
from safetensors.torch import load_file


@pytest.fixture(autouse=True)
def _one_thread() -> Iterator[None]:
    """Small pictures gain nothing by more, and tests run side by side."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="module")
def town(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """Return a set of one short episode of small pictures."""
    preset = "quick[frame_count=128,height_px=120,rate_hz=3,width_px=160]"
    request = Request("road-town-v2", preset, (3, 4), ("image_rgb", "semantic_map"))
    return generate(request, str(tmp_path_factory.mktemp("town")), Workers(0), lambda done, of: None)


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
    ground, _ = samples[40]
    model = learn_roads.RoadNetwork()
    model.load_state_dict(load_file(weights))
    with torch.no_grad():
        expected = model(ground[None])[0].numpy()
    found = RoadNetwork(weights).log_odds(ground.permute(1, 2, 0).numpy())
    assert np.allclose(found, expected, atol=1e-3 * np.abs(expected).max())
