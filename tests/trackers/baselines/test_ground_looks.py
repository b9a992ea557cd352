"""Looks of a car from above, and the projection of the ground, against independent formulas."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.baselines.ground_looks import ColourLook, Look, TemplateLook, middle_of
from trackers.baselines.ground_view import GroundViews
from trackers.types import CameraModel, EgoPose, Observation

SIDE = 12


def texture(size: tuple[int, int], seed: int) -> NDArray[np.uint8]:
    """Return a smooth random picture (rows, columns, 3)."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 256, (size[0] // 3 + 2, size[1] // 3 + 2, 3), dtype=np.uint8)
    return cv2.resize(coarse, size[::-1], interpolation=cv2.INTER_CUBIC)


def turned_into(ground: NDArray[np.uint8], car: NDArray[np.uint8], place: tuple[int, int], turn_rad: float) -> None:
    """Draw the middle 14 cells of ``car`` into ``ground`` around (column, row), turned from x towards y."""
    M = cv2.getRotationMatrix2D((19.5, 19.5), -np.rad2deg(turn_rad), 1.0)
    patch = middle_of(cv2.warpAffine(car, M, (40, 40)), 22)
    rows, columns = np.mgrid[0:22, 0:22] - 10.5
    disc = np.hypot(rows, columns) < 10.5
    column, row = place
    ground[row - 11 : row + 11, column - 11 : column + 11][disc] = patch[disc]


@pytest.mark.parametrize("turn_rad", [0.0, 0.7, 2.5, -1.9])
def test_a_template_finds_the_car_at_any_turn(turn_rad: float) -> None:
    car, ground = texture((40, 40), 1), texture((90, 120), 2)
    turned_into(ground, car, (70, 40), turn_rad)
    spot = TemplateLook(car, SIDE, 7).anywhere(ground, np.ones(ground.shape[:2], bool))
    assert spot is not None
    assert np.abs(spot.centre - [70, 40]).max() <= 1.0
    assert np.abs(np.angle(np.exp(1j * (spot.turn_rad - turn_rad)))) < 0.15
    assert spot.similarity > 0.75


def test_a_template_near_its_turn_is_found_and_far_from_it_not() -> None:
    car, ground = texture((40, 40), 1), texture((60, 60), 2)
    turned_into(ground, car, (30, 31), 1.0)
    look, allowed = TemplateLook(car, SIDE, 7), np.ones((60, 60), bool)
    near, far = look.near(ground, allowed, 0.95), look.near(ground, allowed, -1.2)
    assert near is not None
    assert far is not None
    assert np.abs(near.centre - [30, 31]).max() <= 1.0
    assert far.similarity < 0.7 < near.similarity


def test_colours_are_found_at_any_turn() -> None:
    ground = np.full((80, 100, 3), (90, 90, 92), np.uint8)
    cv2.ellipse(ground, (61, 33), (10, 5), 40.0, 0.0, 360.0, (200, 30, 40), -1)
    car = np.full((60, 60, 3), (90, 90, 92), np.uint8)
    cv2.ellipse(car, (30, 30), (10, 5), 0.0, 0.0, 360.0, (200, 30, 40), -1)
    spot = ColourLook(car, 7).anywhere(ground, np.ones((80, 100), bool))
    assert spot is not None
    assert np.abs(spot.centre - [61.5, 33.5]).max() <= 5.0
    assert spot.similarity == pytest.approx(1.0)


def test_a_template_of_one_colour_matches_nothing() -> None:
    even = np.full((40, 40, 3), 90, np.uint8)
    allowed = np.ones((40, 40), bool)
    assert TemplateLook(even, SIDE, 7).anywhere(even, allowed) is None
    assert TemplateLook(even, SIDE, 7).near(even, allowed, 0.0) is None


@given(st.integers(1, 45), st.integers(1, 45), st.integers(0, 200), st.booleans())
@settings(max_examples=60, deadline=None)
def test_only_allowed_cells_are_answered(rows: int, columns: int, seed: int, colours: bool) -> None:
    rng = np.random.default_rng(seed)
    patch, allowed = texture((rows, columns), seed), rng.random((rows, columns)) < rng.choice([0.0, 0.05, 0.9])
    look: Look = ColourLook(texture((40, 40), 0), 7) if colours else TemplateLook(texture((40, 40), 0), SIDE, 7)
    for spot in (look.near(patch, allowed, 0.3), look.anywhere(patch, allowed)):
        if spot is not None:
            column, row = spot.centre.astype(int)
            assert allowed[row, column]
            assert -1.0 <= spot.similarity <= 1.0


def _observation(T: NDArray[np.float64] | None, image: NDArray[np.uint8]) -> Observation:
    height, width = image.shape[:2]
    return Observation(image, 0.0, CameraModel(width, height, 1.1 * width), ego=None if T is None else EgoPose(T))


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.0, 3.0), st.floats(20.0, 120.0))
@settings(max_examples=40, deadline=None)
def test_the_ground_is_projected_as_by_a_pinhole_camera(roll: float, pitch: float, yaw: float, height_m: float) -> None:
    turn = cv2.Rodrigues(np.array([0.0, 0.0, yaw]))[0] @ cv2.Rodrigues(np.array([roll, pitch, 0.0]))[0]
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = turn @ np.diag([1.0, -1.0, -1.0]), [3.0, -7.0, height_m]
    view = GroundViews(_observation(T, np.zeros((120, 160, 3), np.uint8)), np.array([70.0, 50, 90, 70])).view
    points = np.array([[3.0, -7.0], [10.0, 2.0], [-5.0, -20.0]])
    in_camera = (np.column_stack([points, np.full(3, 0.7)]) - T[:3, 3]) @ T[:3, :3]
    expected = [80, 60] + 176.0 * in_camera[:, :2] / in_camera[:, 2:]
    np.testing.assert_allclose(view.to_picture(points), expected, atol=1e-6)
    np.testing.assert_allclose(view.to_ground(expected), points, atol=1e-6)


def test_a_rectified_cell_shows_its_own_ground() -> None:
    image = texture((120, 160), 3)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(np.array([0.2, -0.3, 0.5]))[0] @ np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 40.0]
    view = GroundViews(_observation(T, image), np.array([70.0, 50, 90, 70])).view
    corner_m, cell_m = view.to_ground(np.array([[80.0, 60.0]]))[0] - 4.0, 0.25
    patch = view.rectified(image, corner_m, (32, 32), cell_m)
    for column, row in ((3, 5), (16, 16), (30, 9)):
        x, y = view.to_picture((corner_m + cell_m * (np.array([column, row]) + 0.5))[None])[0] - 0.5
        expected = cv2.getRectSubPix(image, (1, 1), (x, y))[0, 0]
        assert np.abs(patch[row, column].astype(int) - expected).max() <= 6
