"""What is read of an observation, and its noise."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA
from trackers.site.reading import noise_of, reading_of
from trackers.types import Observation

GREY = np.arange(12, dtype=np.uint8).reshape(3, 4)
COUNTS = 100 + GREY.astype(np.uint16)


def observed(counts) -> Observation:
    return Observation(np.broadcast_to(GREY[..., None], (3, 4, 3)), 0.0, CAMERA, counts=counts)


@pytest.mark.parametrize(
    ("counts", "wanted", "expected"),
    [(COUNTS, True, COUNTS), (COUNTS, False, GREY), (None, True, GREY), (COUNTS[:2], True, GREY)],
)
def test_counts_are_read_where_there_are_any(counts, wanted, expected):
    np.testing.assert_array_equal(reading_of(observed(counts), wanted), expected)


def test_the_noise_is_that_of_each_place_without_common_steps_and_outliers():
    rng = np.random.default_rng(0)
    sigma = np.where(np.arange(60) < 30, 4.0, 9.0)
    pictures = rng.normal(0.0, sigma, (300, 40, 60)) + 50.0 * rng.normal(size=(300, 1, 1))
    pictures[rng.random(pictures.shape) < 0.02] += 500.0
    noise = noise_of(pictures.astype(np.float32))
    assert noise[:, :28].mean() == pytest.approx(4.0, rel=0.1)
    assert noise[:, 32:].mean() == pytest.approx(9.0, rel=0.1)
    assert noise_of(np.zeros((5, 6, 7), np.float32)).max() == 0.5


def test_one_picture_has_the_noise_of_its_fine_structure():
    picture = np.random.default_rng(1).normal(200.0, 6.0, (1, 80, 90)).astype(np.float32)
    noise = noise_of(picture)
    assert noise.shape == (80, 90)
    np.testing.assert_allclose(noise, 6.0, rtol=0.35)
