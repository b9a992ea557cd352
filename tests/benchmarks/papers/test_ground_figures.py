"""Figures 2 to 5 of paper A, on a hand-drawn town."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.papers.ground_figures import figures_of
from tests.fakes import CAMERA, DrawnTown, drive, look_down, straight_road
from trackers.road_shape.existence import ClassStatistics

GREY, GREEN = (82.0, 82.0, 86.0), (88.0, 118.0, 62.0)
STATISTICS = ClassStatistics(np.array([GREY, GREEN]), np.full((2, 3), 400.0), np.array([True, False]))
BLUE, RED = (0, 0, 255), (255, 0, 0)


def share(image_rgb: NDArray[np.uint8], colour: tuple[int, int, int]) -> float:
    """Return the share of the pixels that have a colour."""
    return float((image_rgb == colour).all(axis=-1).mean())


@pytest.fixture(scope="module")
def figures() -> dict[str, NDArray[np.uint8]]:
    """Return the figures of a car on a road along the picture, by their number."""
    road = straight_road()
    town = DrawnTown(road, 220.0, np.random.default_rng(1))
    (frame,) = drive(town, road, 110.0, 0.0, [look_down(0, 0, 60.0, np.pi / 2)])
    return {words[0]: image for words, image in figures_of(frame.observation, frame.box_xyxy, STATISTICS)}


def test_the_classes_are_corrected_along_the_road_alone(figures: dict[str, NDArray[np.uint8]]) -> None:
    assert list(figures) == ["2", "3", "4", "5"]
    assert {image.shape for image in figures.values()} == {(2 * CAMERA.height_px, 2 * CAMERA.width_px, 3)}
    classes, corrected = figures["3"], figures["5"]
    changed = (classes != corrected).any(axis=-1)
    # Car, lines and pavements were building, and are road now; nothing else has changed.
    assert 0.01 < changed.mean() < 0.2
    assert (corrected[changed] == BLUE).all()
    assert share(corrected, RED) < share(classes, RED)
    rows = np.flatnonzero(changed.any(axis=1))
    assert np.ptp(rows) < 0.4 * len(changed)


def test_the_road_is_drawn_into_the_picture(figures: dict[str, NDArray[np.uint8]]) -> None:
    drawn = (figures["2"] != figures["4"]).any(axis=-1)
    # Three lines from one side to the other.
    assert drawn.any(axis=0).mean() > 0.7
    assert 0.005 < drawn.mean() < 0.1
