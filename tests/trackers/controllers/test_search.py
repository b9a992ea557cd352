"""``search`` is ``centre`` while the position is known, and otherwise flies an expanding square."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import look_down_pose, project
from trackers.controllers.centre import CentreController, CentreParameters
from trackers.controllers.search import SearchController, SearchParameters, expanding_square
from trackers.types import CameraModel, EgoPose, Estimate, Observation

CAMERA = CameraModel.from_field_of_view(640, 480, np.deg2rad(50))
T = look_down_pose(np.array([5.0, -3.0, 50.0]), 0.4, 0.1, 0.0)


def _observation(k):
    return Observation(np.zeros((2, 2, 3), np.uint8), k / 15, CameraModel(640, 480, CAMERA.focal_px), ego=EgoPose(T))


def _estimate(place_m, seen, spread_px=5.0):
    pixel, _ = project(CAMERA, T, np.array([*place_m, 0.0]))
    return Estimate(pixel, in_view_probability=float(seen), covariance_px=spread_px**2 * np.eye(2))


def test_known_it_is_centre():
    search, centre = SearchController(SearchParameters()), CentreController(CentreParameters())
    for k in range(90):
        # Out of view most of the time, but its position is known.
        estimate = _estimate((8.0 + 0.1 * k, -3.0), seen=k < 10)
        assert search.command(_observation(k), estimate) == centre.command(_observation(k), estimate)


@pytest.mark.parametrize("silent", [False, True])
def test_lost_it_flies_about_the_place_last_seen(silent):
    search = SearchController(SearchParameters(patience_s=1.0))
    for k in range(10):
        search.command(_observation(k), _estimate((5.0, -3.0), seen=True))
    lost = Estimate(np.full(2, np.nan)) if silent else _estimate((60.0, 40.0), seen=False, spread_px=600.0)
    commands = [search.command(_observation(k), lost) for k in range(10, 200)]
    velocity_mps = np.array([[command.forward_mps, command.right_mps] for command in commands[20:]])
    assert np.isfinite(velocity_mps).all()
    assert np.hypot(*velocity_mps.T).max() <= SearchParameters().fastest_mps + 1e-9
    # The square goes all around.
    assert (velocity_mps.max(axis=0) > 5.0).all()
    assert (velocity_mps.min(axis=0) < -5.0).all()


def test_the_square_expands():
    corners = [expanding_square(way, 2.0) for way in (0.0, 2.0, 4.0, 8.0, 12.0, 18.0)]
    np.testing.assert_allclose(corners, [[0, 0], [2, 0], [2, 2], [-2, 2], [-2, -2], [4, -2]], atol=1e-12)
