"""Waves of the tile against a direct sum, their statistics and the dispersion relation."""

from __future__ import annotations

import numpy as np
import pytest

from sim.thermal.waves import CELLS, TILE_M, SeaState, SeaWaves
from tests.sim.wave_heights import heights_m

SWELL = SeaState(wind_wave_m=0.0, swell_m=0.4, swell_length_m=16.0, swell_rad=0.5)


def test_slopes_are_those_of_one_surface():
    """Both slopes come from the same heights, at the same places."""
    waves = SeaWaves(SeaState(wind_wave_m=0.3, peak_m=8.0), np.random.default_rng(0))
    for waves.time_s in (0.0, 12_345.6):
        slopes = waves.slopes()
        cells = np.random.default_rng(1).integers(0, CELLS, (200, 2))
        _, wanted = heights_m(waves, cells * TILE_M / CELLS)
        np.testing.assert_allclose(slopes[cells[:, 1], cells[:, 0]], wanted, atol=1e-5)
        assert wanted.std() > 0.05


@pytest.mark.heavy
@pytest.mark.parametrize("state", [SWELL, SeaState(wind_wave_m=0.3, peak_m=4.0, swell_m=0.0, wind_rad=0.7)])
def test_the_significant_height_is_four_deviations(state):
    heights = []
    for seed in range(20):
        waves = SeaWaves(state, np.random.default_rng(seed))
        heights.append(heights_m(waves, np.random.default_rng(seed).uniform(0, TILE_M, (400, 2)))[0])
    assert 4 * np.std(heights) == pytest.approx(state.significant_m, rel=0.1)


def test_swell_runs_where_it_should_as_fast_as_deep_water_lets_it():
    waves = SeaWaves(
        SeaState(wind_wave_m=0.0, swell_m=0.5, swell_length_m=24.0, swell_rad=0.0), np.random.default_rng(5)
    )
    line = np.stack([np.linspace(0, TILE_M, 480, endpoint=False), np.zeros(480)], axis=-1)
    before = heights_m(waves, line)[0]
    waves.time_s = 0.5
    after = heights_m(waves, line)[0]
    shifts = [np.corrcoef(np.roll(before, k), after)[0, 1] for k in range(-60, 60)]
    # The phase runs at sqrt(g L / 2 pi).
    assert (np.argmax(shifts) - 60) * TILE_M / 480 == pytest.approx(0.5 * np.sqrt(9.81 * 24.0 / (2 * np.pi)), abs=0.5)


def test_wind_makes_waves_along_its_way():
    slopes = SeaWaves(SeaState(wind_wave_m=0.2, swell_m=0.0, wind_rad=0.0), np.random.default_rng(6)).slopes()
    along, across = slopes.std(axis=(0, 1))
    assert along > 1.4 * across


def test_a_generator_makes_one_sea():
    first, again, other = (SeaWaves(SWELL, np.random.default_rng(seed)).slopes() for seed in (7, 7, 8))
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != other.tobytes()
    with pytest.raises(ValueError, match=r"^fine_slope: expected a number in \[0.01, 0.4\], got 0"):
        SeaState(fine_slope=0.0)
