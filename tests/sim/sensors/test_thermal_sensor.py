"""The thermal sensor: noise and patterns by their statistics, corrections by the shutter, the gain control's loop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sim.optics import PinholeCamera
from sim.sensors.thermal_sensor import (
    BIN_COUNTS,
    BINS,
    PER_RADIANCE,
    REFERENCE_K,
    ThermalConfig,
    ThermalSensor,
    bin_at,
    right_tone,
)
from sim.thermal.radiance import band_radiance, band_slope

CAMERA = PinholeCamera(96, 72, 200.0)
QUIET = ThermalConfig(
    rate_hz=1.0, netd_k=0.0, fixed_pattern_k=0.0, drift_k=0.0, bowl_k=0.0, level_k=0.0, gain_spread=0.0, blur_px=0.0
)
COUNTS_PER_K = PER_RADIANCE * float(band_slope(REFERENCE_K))


def _flat(kelvin: float = REFERENCE_K) -> NDArray[np.float32]:
    return np.full((72, 1, 96), band_radiance(kelvin), np.float32)


def _scene(rng: np.random.Generator, spread_k: float = 3.0) -> NDArray[np.float32]:
    return band_radiance(rng.normal(290.0, spread_k, (72, 1, 96))).astype(np.float32)


def _sensor(seed: int = 0, **changes: float) -> ThermalSensor:
    return ThermalSensor(replace(QUIET, **changes), np.random.default_rng(seed))


def _readings_k(sensor: ThermalSensor, frames: range) -> NDArray[np.float64]:
    """Return deviations from the reference in kelvins (F, H, W)."""
    counts = np.array([sensor._counts(_flat()[:, 0], frame) for frame in frames], float)
    return (counts - PER_RADIANCE * (band_radiance(REFERENCE_K) - band_radiance(233.0))) / COUNTS_PER_K


def test_counts_are_linear_in_radiance_over_the_range():
    kelvin = np.array([233.0, 260.0, 300.0, 360.0, 423.0])
    picture = np.repeat(band_radiance(kelvin), 1).astype(np.float32)[None].repeat(3, axis=0)
    counts = _sensor()._counts(np.ascontiguousarray(picture), 0)[1]
    share = (band_radiance(kelvin) - band_radiance(233.0)) / (band_radiance(423.0) - band_radiance(233.0))
    np.testing.assert_allclose(counts, 16383 * share, atol=1.0)
    beyond = np.float32([[1.0, 400.0]])
    assert _sensor()._counts(beyond, 0).tolist() == [[0, 16383]]


def test_noise_from_picture_to_picture_is_the_netd():
    sensor = _sensor(netd_k=0.06)
    first, second = _readings_k(sensor, range(2))
    assert np.std(second - first) / np.sqrt(2) == pytest.approx(0.06, rel=0.05)
    noise = _readings_k(sensor, range(40))
    assert abs(noise.mean()) < 0.01
    # Pixels and pictures are independent.
    assert abs(np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]) < 0.05
    assert abs(np.corrcoef(noise[0, :, :-1].ravel(), noise[0, :, 1:].ravel())[0, 1]) < 0.05


def test_the_pattern_grows_from_its_residue_until_the_next_correction():
    sensor = _sensor(fixed_pattern_k=0.025, drift_k=0.08, shutter_every_s=100.0)
    start = int(np.ceil(100.0 * (1.0 - sensor._phase)))
    spread = [np.std(_readings_k(sensor, range(start + k, start + k + 1))) for k in (0, 50, 99)]
    ages = (np.arange(3) * 0.5).tolist()
    for found, age in zip(spread, ages, strict=True):
        assert found == pytest.approx(np.hypot(0.025, 0.08 * age), rel=0.15)
    after = np.std(_readings_k(sensor, range(start + 100, start + 101)))
    assert after == pytest.approx(0.025, rel=0.15)


def test_a_correction_leaves_another_pattern_and_another_level():
    sensor = _sensor(fixed_pattern_k=0.05, level_k=0.3, shutter_every_s=10.0)
    epochs = _readings_k(sensor, range(5, 405, 10))
    patterns = epochs - epochs.mean(axis=(1, 2), keepdims=True)
    assert abs(np.corrcoef(patterns[0].ravel(), patterns[1].ravel())[0, 1]) < 0.05
    assert np.std(epochs.mean(axis=(1, 2))) == pytest.approx(0.3, rel=0.3)
    same = _readings_k(sensor, range(6, 8))
    np.testing.assert_array_equal(same[0], same[1])


def test_a_quarter_of_the_drift_is_in_columns_and_corners_drift_from_the_middle():
    sensor = _sensor(drift_k=0.4, shutter_every_s=1000.0)
    sensor._phase = 0.0
    late = _readings_k(sensor, range(999, 1000))[0]
    columns = np.var(late.mean(axis=0)) - np.var(late - late.mean(axis=0)) / 72
    assert columns == pytest.approx(0.25 * 0.4**2, rel=0.35)
    bowl = _sensor(bowl_k=1.0, shutter_every_s=1000.0)
    bowl._phase = 0.0
    late = _readings_k(bowl, range(999, 1000))[0]
    assert abs(late[0, 0] - late[36, 48]) == pytest.approx(1.0, abs=0.05)
    assert abs(late.mean()) < 0.05


def test_blur_spreads_by_its_deviation_and_keeps_the_sum():
    picture = np.full((31, 31), band_radiance(280.0), np.float32)
    picture[15, 15] += 50.0
    counts = _sensor(blur_px=0.6)._counts(picture, 0).astype(float)
    share = (counts - counts[0, 0]) / (50.0 * PER_RADIANCE)
    assert share.sum() == pytest.approx(1.0, abs=1e-2)
    across = share.sum(axis=0) @ (np.arange(31) - 15.0) ** 2
    assert np.sqrt(across) == pytest.approx(0.6, abs=0.02)


def test_a_picture_is_held_while_the_shutter_is_closed_and_the_next_one_has_stepped():
    sensor, rng = _sensor(netd_k=0.05, level_k=0.2, shutter_every_s=20.0, shutter_s=2.0), np.random.default_rng(1)
    sensor._phase, scene = 0.5, _scene(rng)
    taken = [sensor.expose(scene, CAMERA, frame) for frame in range(120)]
    held = np.array([each.settings.is_held for each in taken])
    assert held.sum() in (12, 15)
    for k in np.flatnonzero(held):
        assert taken[k].counts is taken[k - 1].counts
    opened = np.flatnonzero(held[:-1] & ~held[1:]) + 1
    assert all(taken[k].settings.has_stepped for k in opened)
    others = np.setdiff1d(np.flatnonzero(~held), opened)
    assert not any(taken[k].settings.has_stepped for k in others if k > 0)


def test_a_sequence_is_the_same_bytes_and_counts_do_not_depend_on_what_was_taken_before():
    scene, config = _scene(np.random.default_rng(2)), ThermalConfig()
    runs = [ThermalSensor(config, np.random.default_rng(3)) for _ in range(2)]
    first, again = ([sensor.expose(scene, CAMERA, k) for k in range(8)] for sensor in runs)
    for one, other in zip(first, again, strict=True):
        assert one.counts.tobytes() == other.counts.tobytes()
        assert one.image_rgb.tobytes() == other.image_rgb.tobytes()
    alone = ThermalSensor(config, np.random.default_rng(3)).expose(scene, CAMERA, 7)
    assert alone.counts.tobytes() == first[7].counts.tobytes()
    developed = runs[0].develop(scene, CAMERA, 7, first[7].settings)
    assert developed.image_rgb.tobytes() == first[7].image_rgb.tobytes()
    assert first[0].image_rgb.shape == (72, 96, 3)


# The gain control -----------------------------------------------------------------------------------------------------


@given(st.integers(0, 10_000), st.floats(0.0, 0.5), st.floats(1e-3, 1.0))
@settings(max_examples=40, deadline=None)
def test_tones_rise_within_8_bits_and_no_step_is_too_steep(seed, linear, plateau):
    rng = np.random.default_rng(seed)
    found = np.bincount(np.clip(rng.normal(2000, rng.uniform(1, 300), 20_000), 0, BINS - 1).astype(int), minlength=BINS)
    tone = right_tone(found, plateau, linear, 3.0)
    steps = np.diff(tone.astype(float))
    assert (steps >= 0).all()
    assert steps.max() <= 3.0 + 1e-3
    assert -1e-3 <= tone[0] <= tone[-1] <= 255.0 + 1e-3
    assert tone[0] == pytest.approx(255.0 - tone[-1], abs=1e-2)


def test_without_a_plateau_grey_is_the_share_of_darker_pixels():
    # Equalisation: with the plateau at the whole picture, only the linear share is not of the histogram.
    rng = np.random.default_rng(5)
    found = np.bincount(np.clip(rng.gamma(2.0, 150.0, 50_000), 0, BINS - 1).astype(int), minlength=BINS)
    tone = right_tone(found, 1.0, 0.0, 255.0)
    below = (np.cumsum(found) - 0.5 * found) / found.sum()
    inner = slice(bin_at(found, 0.01), bin_at(found, 0.99))
    np.testing.assert_allclose(tone[inner], 255.0 * below[inner], atol=0.6)


def test_a_plateau_keeps_levels_from_wide_even_surfaces():
    found = np.zeros(BINS, np.int64)
    found[1000], found[1100:1300] = 60_000, 50
    whole, limited = (right_tone(found, plateau, 0.0, 255.0) for plateau in (1.0, 0.002))
    assert whole[1299] - whole[1100] < 40
    assert limited[1299] - limited[1100] > 150


def test_dull_scenes_are_not_stretched_beyond_the_largest_gain():
    sensor = _sensor(netd_k=0.05, largest_gain=20.0)
    picture = sensor.expose(_flat(), CAMERA, 0)
    assert picture.settings.gain == pytest.approx(20.0, rel=0.05)
    assert picture.image_rgb.std() < 2.5
    assert 110 < picture.image_rgb.mean() < 145


def test_the_loop_settles_with_its_time_constant_and_says_when_it_jumps():
    config = {"netd_k": 0.03, "settling_s": 5.0, "shutter_every_s": 1e6, "linear": 0.4}
    sensor, scene = _sensor(**config), _scene(np.random.default_rng(6))
    sensor._phase = 0.5
    for frame in range(10):
        before = sensor.expose(scene, CAMERA, frame)
    hot = scene.copy()
    hot[20:32, 0, 30:48] = band_radiance(350.0)
    entered = [sensor.expose(hot, CAMERA, frame) for frame in range(10, 40)]
    assert not before.settings.has_stepped
    assert entered[0].settings.has_stepped
    assert not entered[-1].settings.has_stepped
    gains = np.array([before.settings.gain] + [each.settings.gain for each in entered])
    assert gains[-1] < 0.8 * gains[0]
    # Each step goes 1 - exp(-1 / 5) of the rest of the way.
    rest = (gains[:12] - gains[-1]) / (gains[0] - gains[-1])
    np.testing.assert_allclose(rest, np.exp(-np.arange(12) / 5.0), atol=0.06)


def test_after_a_pause_the_loop_has_settled():
    slow, scene = _sensor(settling_s=5.0, netd_k=0.03), _scene(np.random.default_rng(7))
    slow.expose(_scene(np.random.default_rng(8), spread_k=12.0), CAMERA, 0)
    later = slow.expose(scene, CAMERA, 500)
    fresh = _sensor(netd_k=0.03).expose(scene, CAMERA, 500)
    np.testing.assert_allclose(later.settings.tone, fresh.settings.tone, atol=0.01)


def test_gain_is_grey_levels_per_kelvin():
    rng = np.random.default_rng(9)
    kelvin = rng.uniform(285.0, 295.0, (72, 96))
    picture = _sensor().expose(band_radiance(kelvin)[:, None].astype(np.float32), CAMERA, 0)
    grey = picture.image_rgb[..., 0].astype(float)
    middle = (kelvin > 287.5) & (kelvin < 292.5)
    slope = np.polyfit(kelvin[middle], grey[middle], 1)[0]
    assert picture.settings.gain == pytest.approx(slope, rel=0.03)


def test_counts_of_a_bin_show_one_grey_level():
    picture = _sensor().expose(_scene(np.random.default_rng(10)), CAMERA, 0)
    wanted = np.round(picture.settings.tone)[picture.counts // BIN_COUNTS]
    np.testing.assert_array_equal(picture.image_rgb[..., 0], wanted)


@pytest.mark.parametrize(("name", "value"), [("blur_px", 0.9), ("netd_k", -0.1), ("plateau", 0.0), ("rate_hz", 0.0)])
def test_impossible_sensors_are_refused(name, value):
    with pytest.raises(ValueError, match=f"^{name}: expected a number in"):
        ThermalConfig(**{name: value})
