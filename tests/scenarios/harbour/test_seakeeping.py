"""Boats on waves: long ones carry them along, short ones do not; roll has a period of its own."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.harbour.conditions import Rocking
from scenarios.harbour.seakeeping import afloat_on, roll_period_s
from sim.rng import generator
from sim.thermal.waves import CELLS, TILE_M, SeaState, SeaWaves

TIME_S = 0.25 * np.arange(8000)


def on(waves: SeaWaves, heading_rad: float = 0.0, length_m: float = 8.0, beam_m: float = 2.8) -> Rocking:
    place_m = np.tile((3.0, -5.0), (len(TIME_S), 1))
    return afloat_on(waves, TIME_S, place_m, np.full(len(TIME_S), heading_rad), length_m, beam_m)


def swell(length_m: float, height_m: float = 0.8, towards_rad: float = 0.0) -> SeaWaves:
    state = SeaState(wind_wave_m=0.0, swell_m=height_m, swell_length_m=length_m, swell_rad=towards_rad)
    return SeaWaves(state, generator(2, "waves"))


def test_long_waves_carry_a_small_boat_as_high_as_they_are_and_turn_it_as_steep() -> None:
    """A significant height is four standard deviations."""
    waves = swell(46.0)
    small = on(waves, length_m=0.5, beam_m=0.2)
    kx, _, _, amplitude = waves.strongest(96)
    assert small.heave_m.std() == pytest.approx(0.5**0.5 * np.hypot.reduce(np.abs(amplitude)), rel=0.1)
    steep = 0.5**0.5 * np.hypot.reduce(kx * np.abs(amplitude))
    assert small.pitch_rad.std() == pytest.approx(steep, rel=0.1)


def test_the_surface_that_carries_is_the_one_that_is_seen() -> None:
    """The slope that the picture is made of is the pitch of a speck."""
    waves, place = swell(30.0), np.array([[12.0 * TILE_M / CELLS, 40.0 * TILE_M / CELLS]])
    for time_s in (0.0, 3.7, 61.0):
        waves.time_s = time_s
        slope = waves.slopes()[40, 12, 0]
        speck = afloat_on(waves, np.array([time_s]), place, np.zeros(1), 1e-3, 1e-3)
        assert np.tan(-speck.pitch_rad[0]) == pytest.approx(slope, rel=0.02, abs=1e-4)


def test_waves_shorter_than_a_boat_hardly_move_it() -> None:
    short, long = on(swell(9.0), length_m=18.0), on(swell(46.0), length_m=18.0)
    assert short.heave_m.std() < 0.2 * long.heave_m.std()


def test_waves_from_ahead_pitch_and_waves_from_abeam_roll() -> None:
    ahead, abeam = on(swell(30.0), 0.0), on(swell(30.0), 0.5 * np.pi)
    assert ahead.pitch_rad.std() > 2.0 * ahead.roll_rad.std()
    assert abeam.roll_rad.std() > 2.0 * abeam.pitch_rad.std()
    assert np.abs(abeam.roll_rad).max() < 0.6


def test_no_waves_no_motion_and_wider_boats_roll_more_slowly() -> None:
    still = on(swell(30.0, 0.0))
    assert not still.heave_m.any()
    assert 1.5 < roll_period_s(6.0, 2.0) < roll_period_s(9.0, 3.2) < 5.0
