"""Paper B's formulas of the change of the light, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackers.light_adaptive_stereo.light_change import (
    LightTrend,
    brightness_change,
    colour_change,
    dissimilarity,
    shutter_and_gain,
    white_balance_change,
)
from trackers.light_adaptive_stereo.stereo_colour import StereoColourParameters
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
    assert white_balance_change(now, AT_REST) == 200
    assert colour_change(200, unit=1023.0) == pytest.approx(0.4 * 200 / 1023)
    assert colour_change(200, unit=40.0) == 1.0
    assert brightness_change(now, AT_REST) == pytest.approx(6.0 * 5 / 177 + 0.9 * 10 / 342)


def _colour_change(now: CameraRegisters, then: CameraRegisters) -> float:
    return colour_change(white_balance_change(now, then), StereoColourParameters().white_balance_unit)


@given(REGISTERS, REGISTERS)
def test_changes_are_shares_and_the_same_both_ways(one, other):
    for change in (_colour_change, brightness_change):
        assert change(one, one) == 0.0
        assert 0.0 <= change(one, other) <= 1.0
        assert change(one, other) == change(other, one)


def test_only_white_balance_tells_of_colour_and_only_shutter_and_gain_of_brightness():
    assert white_balance_change(CameraRegisters(400, 600, 707, 683), AT_REST) == 0
    assert brightness_change(CameraRegisters(0, 1023, 200, 0), AT_REST) == 0.0


def test_dissimilarity_is_the_hellinger_distance():
    rng = np.random.default_rng(0)
    p, q = rng.dirichlet(np.ones(128)), rng.dirichlet(np.ones(128))
    hellinger = np.linalg.norm(np.sqrt(p) - np.sqrt(q)) / np.sqrt(2)
    assert dissimilarity(p, q) == pytest.approx(hellinger)
    assert dissimilarity(p, p) == pytest.approx(0.0, abs=1e-7)
    assert dissimilarity(np.eye(128)[0], np.eye(128)[1]) == 1.0


def _trend(shutters: list[int], gains: list[int]) -> list[float]:
    trend = LightTrend()
    return [trend.update(CameraRegisters(512, 512, s, g)) for s, g in zip(shutters, gains, strict=True)]


def test_at_constant_settings_there_is_no_trend():
    assert _trend([300] * 15, [0] * 15) == [0.0] * 15


def test_a_shutter_that_lengthens_evenly_has_the_slope_by_hand():
    # One step a frame: h rises by 10 / 177 a frame, over any ten frames.
    shutters = [4 * k for k in range(50, 80)]
    trend = _trend(shutters, [0] * 30)
    for frame in range(1, 30):
        assert trend[frame] == pytest.approx(10 / 177 * 177 / (50 + frame))
    assert _trend(shutters[::-1], [0] * 30)[-1] < 0


def test_the_slope_is_that_of_the_last_ten_frames_by_numpy():
    rng = np.random.default_rng(3)
    shutters = rng.integers(100, 600, 25).tolist()
    exposures = 10 * np.floor(np.array(shutters[-10:]) / 4 + 0.5) / 177
    expected = np.polyfit(np.arange(10), exposures, 1)[0] * 177 / np.floor(shutters[-1] / 4 + 0.5)
    assert _trend(shutters, [0] * 25)[-1] == pytest.approx(expected)


def test_at_the_longest_shutter_the_gain_is_the_scale():
    assert _trend([707] * 12, [2 * k for k in range(40, 52)])[-1] == pytest.approx(10 / 342 * 342 / 51)
    # No gain at all counts as one step.
    assert _trend([703, 707], [0, 0])[-1] == pytest.approx(10 / 177 * 342)
