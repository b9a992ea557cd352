"""How much the light has changed, by the camera's own numbers: paper B's formulas by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackers.light_change import brightness_change, colour_change, dissimilarity, shutter_and_gain
from trackers.types import CameraRegisters

AT_REST = CameraRegisters(red=400, blue=600, shutter=200, gain=0)
REGISTERS = st.builds(
    CameraRegisters, st.integers(0, 1023), st.integers(0, 1023), st.integers(0, 707), st.integers(0, 683)
)


def test_the_papers_largest_steps():
    assert shutter_and_gain(CameraRegisters(0, 0, 707, 683)) == (177, 342)
    assert shutter_and_gain(CameraRegisters(0, 0, 0, 0)) == (0, 0)


def test_by_hand():
    now = CameraRegisters(red=300, blue=700, shutter=220, gain=20)
    assert colour_change(now, AT_REST) == pytest.approx(0.4 * 200 / 1023)
    assert brightness_change(now, AT_REST) == pytest.approx(6.0 * 5 / 177 + 0.9 * 10 / 342)


@given(REGISTERS, REGISTERS)
def test_changes_are_shares_and_the_same_both_ways(one, other):
    for change in (colour_change, brightness_change):
        assert change(one, one) == 0.0
        assert 0.0 <= change(one, other) <= 1.0
        assert change(one, other) == change(other, one)


def test_only_white_balance_tells_of_colour_and_only_shutter_and_gain_of_brightness():
    assert colour_change(CameraRegisters(400, 600, 707, 683), AT_REST) == 0.0
    assert brightness_change(CameraRegisters(0, 1023, 200, 0), AT_REST) == 0.0


def test_dissimilarity_is_the_hellinger_distance():
    rng = np.random.default_rng(0)
    p, q = rng.dirichlet(np.ones(128)), rng.dirichlet(np.ones(128))
    hellinger = np.linalg.norm(np.sqrt(p) - np.sqrt(q)) / np.sqrt(2)
    assert dissimilarity(p, q) == pytest.approx(hellinger)
    assert dissimilarity(p, p) == pytest.approx(0.0, abs=1e-7)
    assert dissimilarity(np.eye(128)[0], np.eye(128)[1]) == 1.0
