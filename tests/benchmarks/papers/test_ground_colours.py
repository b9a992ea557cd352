from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.papers import ground_colours
from benchmarks.papers.ground_colours import CLASSES, label_pixels, learn_colours, write_model
from scenarios import catalog
from scenarios.road_town.road_map import RoadMap
from trackers.paper_a.ground_classes import load_class_statistics


def test_labels_agree_with_what_is_drawn_there() -> None:
    """Labels come from depth and map; the ids of what was drawn are another witness."""
    episode = catalog.scenario("road-town").episode("quick", 3, closed_loop=False)
    frame = episode.step()
    labels = label_pixels(frame, RoadMap(episode.map_of().graph), episode.map_of())
    categories = np.array([body.category for body in episode.world.bodies])  # type: ignore[attr-defined]
    drawn = categories[frame.truth.instance_map]
    stacked = np.stack([labels[name] for name in CLASSES])
    assert (stacked.sum(axis=0) <= 1).all()
    assert stacked.any(axis=0).mean() > 0.7
    assert not np.isin(drawn[stacked.any(axis=0)], ["vehicle"]).any()
    assert (drawn[labels["building"]] == "building").mean() > 0.97
    assert labels["building"][drawn == "building"].mean() > 0.5
    assert not (drawn[labels["road"]] == "building").any()
    episode.close()


def test_moments_are_numpys_and_the_model_is_what_trackers_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ground_colours, "MODEL_PATH", tmp_path / "classes.json")
    model = learn_colours(("quick",), range(3, 4), every=1000)
    episode = catalog.scenario("road-town").episode("quick", 3, closed_loop=False)
    frame = episode.step()
    labels = label_pixels(frame, RoadMap(episode.map_of().graph), episode.map_of())
    episode.close()
    step = ground_colours._PIXEL_STEP
    colours = frame.observation.image_rgb[::step, ::step][labels["road"][::step, ::step]].astype(float)
    np.testing.assert_allclose(model["road"]["mean_rgb"], colours.mean(axis=0), atol=1e-3)
    np.testing.assert_allclose(model["road"]["variance_rgb"], colours.var(axis=0), atol=1e-2)
    path = write_model(model, "frameout learn-colours")
    assert json.loads(path.read_text())["command"] == "frameout learn-colours"
    read = load_class_statistics(str(path))
    np.testing.assert_allclose(read.mean_rgb, [model["road"]["mean_rgb"], model["other"]["mean_rgb"]])
