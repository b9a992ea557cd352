"""The ground's picture and its classes agree with the map, and the picture has corners everywhere."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from scenarios.road_town.blocks import fill_blocks
from scenarios.road_town.canvas import Canvas, rectangle
from scenarios.road_town.ground import class_map, paint_ground
from scenarios.road_town.layout import BUILDING, OTHER, ROAD
from scenarios.road_town.patterns import make_streets
from scenarios.road_town.road_map import RoadMap
from sim.rng import generator


@pytest.fixture(scope="module")
def layout():
    return fill_blocks(make_streets("organic", generator(2, "streets")), generator(2, "blocks"), 420.0)


def test_classes_are_those_of_the_map(layout):
    classes = class_map(layout, 0.5)
    assert classes.shape == (840, 840)
    rng = generator(1, "places")
    places = rng.uniform(-205, 205, (4000, 2))
    cells = np.floor(np.column_stack([210 - places[:, 1], places[:, 0] + 210]) / 0.5).astype(int)
    drawn = classes[cells[:, 0], cells[:, 1]]
    road = RoadMap(layout.graph).is_on_road(places)
    # A cell on the kerb may have either class: at half a metre these are a few per cent of the places.
    assert (road == (drawn == ROAD)).mean() > 0.97
    for building in layout.buildings:
        x, y = building.centre_m
        assert classes[int((210 - y) / 0.5), int((x + 210) / 0.5)] == BUILDING
    assert (classes == OTHER).mean() > 0.4


def test_roads_are_grey_and_meadows_are_green(layout):
    picture = paint_ground(layout, generator(2, "town"), 2048)
    classes = cv2.resize(class_map(layout, 420 / 2048), (2048, 2048), interpolation=cv2.INTER_NEAREST)
    mean = {kind: picture[classes == kind].astype(float).mean(axis=0) for kind in (ROAD, OTHER)}
    assert np.ptp(mean[ROAD]) < 8
    assert mean[OTHER][1] > mean[OTHER][2] + 15


def test_there_are_corners_everywhere(layout):
    picture = cv2.cvtColor(paint_ground(layout, generator(2, "town")), cv2.COLOR_RGB2GRAY)
    # Windows of about the camera's view.
    for row in range(600, 3400, 700):
        for column in range(600, 3400, 700):
            window = picture[row : row + 450, column : column + 600]
            corners = cv2.goodFeaturesToTrack(window, 200, 0.05, 8)
            assert corners is not None
            assert len(corners) >= 40


@pytest.mark.heavy
def test_same_generator_same_picture(layout):
    first, second = (paint_ground(layout, generator(9, "town"), 1024) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_canvas_draws_where_it_is_told():
    canvas = Canvas(np.zeros((1000, 1000, 3), np.uint8), 100.0)
    canvas.polygon(rectangle((20.0, -10.0), (8.0, 4.0), 0.0), (255, 0, 0))
    rows, columns = np.nonzero(canvas.picture[..., 0] > 128)
    assert columns.mean() == pytest.approx((20 + 50) * 10, abs=1)
    assert rows.mean() == pytest.approx((50 + 10) * 10, abs=1)
    assert np.ptp(columns) == pytest.approx(80, abs=2)
    assert np.ptp(rows) == pytest.approx(40, abs=2)


def test_grain_keeps_the_mean_and_has_the_stated_deviation():
    canvas = Canvas(np.full((1024, 1024, 3), 120, np.uint8), 10.0)
    canvas.grain(generator(0, "grain"), 6.0)
    assert canvas.picture.mean() == pytest.approx(120, abs=0.05)
    assert canvas.picture.std() == pytest.approx(6.0, rel=0.02)
