"""The length of a car from its upright box."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.kernels.boxes import WIDTH_TO_LENGTH, apparent_length_px


@pytest.mark.parametrize("heading_rad", [0.0, 0.4, 0.9, 1.5])
def test_the_length_of_a_car_follows_from_its_upright_box(heading_rad: float) -> None:
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    width, height = 40 * (c + WIDTH_TO_LENGTH * s), 40 * (s + WIDTH_TO_LENGTH * c)
    assert apparent_length_px(np.array([10, 20, 10 + width, 20 + height])) == pytest.approx(40.0, rel=1e-6)
