"""What stands on a quay, before its wall and on the water."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW, looking
from trackers.site.quay import shows_water, stood_on
from trackers.site.view import SiteView

QUAY = replace(SURVEY, edge_m=(-15.0, 3.0))


@pytest.mark.parametrize(
    "point_m",
    [
        (0.0, 4.0, 0.0),
        (-14.9, -4.0, 0.0),
        (-15.0, 2.0, -0.5),
        (-15.0, 2.0, -1.7),
        (-15.1, 0.0, -1.8),
        (-40.0, 1.0, -1.8),
    ],
)
def test_points_of_quay_wall_and_water_are_found_where_they_are_seen(point_m: tuple[float, float, float]) -> None:
    px, _ = VIEW.project(np.array([point_m]))
    np.testing.assert_allclose(stood_on(QUAY, VIEW, px), [point_m], atol=1e-6)


def test_the_water_beyond_the_edge_is_seen_from_the_land() -> None:
    view = SiteView(CAMERA, looking(np.array([60.0, 0.0, 20.0]), np.array([-20.0, 0.0, 0.0])))
    for point_m in ((-10.0, 1.0, 0.0), (-60.0, 1.0, -1.8)):
        px, _ = view.project(np.array([point_m]))
        np.testing.assert_allclose(stood_on(QUAY, view, px), [point_m], atol=1e-6)


def test_water_is_shown_where_its_mean_level_is_seen_beyond_the_edge() -> None:
    water = shows_water(QUAY, VIEW)
    assert water.shape == (CAMERA.height_px, CAMERA.width_px)
    for x_m, z_m, expected in ((-15.3, -1.8, True), (-18.0, -1.8, True), (-15.0, -1.5, False), (0.0, 0.0, False)):
        (px,), _ = VIEW.project(np.array([[x_m, 1.0, z_m]]))
        assert water[int(px[1]), int(px[0])] == expected, (x_m, z_m)
    assert not shows_water(QUAY, SiteView(CAMERA, looking(np.array([0.0, 0.0, 9.0]), np.array([9.0, 0.0, 20.0])))).any()


def test_above_the_horizon_there_is_nothing_to_stand_on() -> None:
    assert np.isnan(stood_on(QUAY, VIEW, np.array([[96.0, -200.0]]))).all()


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"mean_water_m": 0.0}, "mean_water_m: expected a finite number of metres < 0, got 0.0"),
        ({"mean_water_m": float("nan")}, "mean_water_m"),
        ({"seaward": (1.0, 1.0)}, "seaward: expected a vector of length 1"),
        ({"edge_m": (float("inf"), 0.0)}, "edge_m: expected finite numbers"),
        ({"watched_m": (90.0, 0.0, 6.0)}, "watched_m: expected three numbers of metres > 0"),
        ({"watched_bottom_m": float("nan")}, "watched_bottom_m: expected a finite number"),
    ],
)
def test_no_survey_is_refused_by_name(changes: dict, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(SURVEY, **changes)
