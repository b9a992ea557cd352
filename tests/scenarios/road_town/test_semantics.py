"""Semantic maps, beside what names of bodies, depth and outlines of roads tell."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from scenarios.catalog import scenario
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.semantics import CLASSES

OF_NAME = {
    "building": "building",
    "tree": "vegetation",
    "wood": "vegetation",
    "hedge": "vegetation",
    "target": "vehicle",
    "traffic": "vehicle",
    "parked": "vehicle",
    "person": "person",
    "cyclist": "person",
    "kerb": "other",
    "props": "other",
    "overpass": "other",
    "fields": "ground",
}


@pytest.fixture(scope="module", params=["quick", pytest.param("oblique", marks=pytest.mark.heavy)])
def shown(request):
    episode = scenario("road-town-v3").episode(request.param, 3)
    frame = episode.step()
    yield episode, frame.truth, frame.camera
    episode.close()


def test_bodies_have_their_classes(shown):
    episode, truth, _ = shown
    names = np.array([*(body.name.replace(" ", "-").split("-")[0] for body in episode.world.bodies), "sky"])
    on_ground = names[truth.instance_map] == "ground"
    expected = np.array([CLASSES.index(OF_NAME.get(name, name)) for name in names], np.uint8)[truth.instance_map]
    np.testing.assert_array_equal(truth.semantic_map[~on_ground], expected[~on_ground])
    assert np.isin(truth.semantic_map[on_ground], (CLASSES.index("road"), CLASSES.index("ground"))).all()


def test_roads_are_where_rays_meet_them(shown):
    episode, truth, camera = shown
    rows, columns = np.nonzero(truth.instance_map == 0)
    rays = np.column_stack([columns + 0.5, rows + 0.5]) - camera.centre_px
    places_m = np.column_stack([rays / camera.focal_px, np.ones(len(rays))]) * truth.depth_m[rows, columns, None]
    places_m = places_m @ truth.T_world_camera[:3, :3].T + truth.T_world_camera[:3, 3]
    roads = RoadMap(episode.map_of().graph)
    edge_m = shapely.distance(roads.area.boundary, shapely.points(places_m[:, :2]))
    sure = edge_m > 0.12
    is_road = truth.semantic_map[rows, columns] == CLASSES.index("road")
    assert sure.mean() > 0.8
    assert 0.05 < is_road.mean() < 0.95
    np.testing.assert_array_equal(is_road[sure], roads.is_on_road(places_m[sure, :2]))


def test_less_truth_has_no_map():
    episode = scenario("road-town").episode("quick", 3, truth="target")
    assert episode.step().truth.semantic_map.size == 0
    episode.close()
