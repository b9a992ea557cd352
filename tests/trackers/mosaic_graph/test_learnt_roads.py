"""The shipped network finds roads in towns that it has not seen, and refuses files that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from benchmarks.judges.frame_out.told import Laid, TrueGround
from scenarios.catalog import scenario
from sim.rng import generator
from trackers import registry
from trackers.kernels.ground_camera import GroundCamera
from trackers.mosaic_graph.learnt_roads import SHIPPED, LearntRoads, RoadNetwork
from trackers.mosaic_graph.mosaic import SHRINK, Mosaic, shrink
from trackers.mosaic_graph.road_network import seen_ground


def test_a_network_of_zeros_is_undecided_and_a_bias_decides(tmp_path: Path) -> None:
    arrays = {name: np.zeros_like(array) for name, array in load_file(SHIPPED).items()}
    arrays["last.bias"][:] = 1.5
    save_file(arrays, tmp_path / "w.safetensors")
    ground = generator(0, "ground").random((16, 24, 3), np.float32)
    assert np.allclose(RoadNetwork(tmp_path / "w.safetensors").log_odds(ground), 1.5)


def test_what_is_no_network_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.safetensors"
    with pytest.raises(ValueError, match="weights: expected a safetensors file, got "):
        RoadNetwork(path)
    path.write_bytes(b"nothing")
    with pytest.raises(ValueError, match="weights: expected a safetensors file"):
        RoadNetwork(path)
    arrays = load_file(SHIPPED)
    save_file({**arrays, "last.bias": np.zeros(2, np.float32)}, path)
    with pytest.raises(ValueError, match=r"weights: .* with last.bias \(2,\)"):
        RoadNetwork(path)
    with pytest.raises(ValueError, match="mosaic_graph_pf: expected text for road_weights, got 3"):
        registry.entry("mosaic_graph_pf").parameters(road_weights=3)
    with pytest.raises(ValueError, match="weights: expected a safetensors file"):
        LearntRoads(tmp_path / "none")


def test_it_finds_the_roads_of_a_town_that_it_has_not_seen() -> None:
    episode = scenario("road-town-v2").episode("quick", 601, truth="target")
    frame = episode.step()
    camera = GroundCamera(frame.camera, frame.truth.T_world_camera, np.zeros(2))
    mosaic = Mosaic(SHRINK * camera.metres_per_pixel())
    small = shrink(frame.observation.image_rgb)
    mosaic.add(small, camera, np.full(small.shape[:2], 255, np.uint8))
    ground = seen_ground(mosaic, camera.footprint_m().mean(axis=0))
    assert ground is not None
    laid = Laid()
    laid.lay(frame, camera)
    true = TrueGround(episode.map_of().graph, laid).probability(ground)[ground.seen] > 0.5
    found = LearntRoads(SHIPPED).probability(ground)[ground.seen] > 0.5
    assert 0.05 < true.mean() < 0.9
    assert np.count_nonzero(true & found) > 0.7 * np.count_nonzero(true | found)
    episode.close()
