"""The sensor against photon statistics, photometry and its own promises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from sim.optics import PinholeCamera
from sim.sensors.automatic import luminance_of, metered_radiance, right_exposure
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig, SensorSettings
from sim.sensors.motion_blur import blur_by_motion
from sim.sensors.noise import CODES, frame_keys, normal_deviates, scatter_row, veil
from sim.shaders.colour import srgb_to_linear

CAMERA = PinholeCamera(320, 240, 300.0)


def _even(luminance_nit: float, width: int = 320, height: int = 240) -> np.ndarray:
    return np.full((height, 3, width), luminance_nit, np.float32)


def _sensor(seed: int = 0, **options) -> CameraSensor:
    return CameraSensor(SensorConfig(**options), np.random.default_rng(seed))


def _deviates(key: int, frame: int, rows: int = 200, width: int = 640) -> np.ndarray:
    out = np.empty((rows, 3, width), np.float32)
    for row in range(rows):
        normal_deviates(frame_keys(key, frame), row, np.empty(out.shape[2], np.uint32), out[row])
    return out


def test_deviates_are_normal_and_independent():
    sample = _deviates(12345, 7)
    count = sample.size
    assert abs(sample.mean()) < 5 / np.sqrt(count)
    assert abs(sample.var() - 1) < 5 * np.sqrt(2 / count)
    assert stats.kurtosis(sample, axis=None) == pytest.approx(0.0, abs=0.05)
    # 1,024 values stand for the distribution.
    assert stats.kstest(sample.ravel()[::7], "norm").statistic < 0.01
    neighbours = [
        (sample[:, 0], sample[:, 1]),
        (sample[:, 1], sample[:, 2]),
        (sample[:, :, 1:], sample[:, :, :-1]),
        (sample[1:], sample[:-1]),
        (sample, _deviates(12345, 8)),
        (sample, _deviates(12346, 7)),
    ]
    for one, other in neighbours:
        assert abs(np.mean(one * other)) < 5 / np.sqrt(one.size)


@given(st.integers(0, 2**63 - 1), st.integers(0, 100_000))
@settings(max_examples=30, deadline=None)
def test_no_frame_repeats_another_ones_noise_shifted(key, frame):
    one, other = (_deviates(key, k, 4, 256).transpose(1, 0, 2).ravel() for k in (frame, frame + 1))
    spectrum = np.fft.rfft(one) * np.conj(np.fft.rfft(other))
    assert np.abs(np.fft.irfft(spectrum, len(one))).max() / len(one) < 0.2


@pytest.mark.parametrize("gain", [1.0, 4.0])
@pytest.mark.parametrize("share", [0.01, 0.1, 0.3])
def test_noise_is_that_of_photons_and_read_out(share, gain):
    config, settings_used = SensorConfig(), SensorSettings(1e-3, gain)
    electrons = share * config.full_well_e / gain
    luminance_nit = electrons / (config.electrons_per_nit_s * settings_used.exposure_s)
    image = _sensor().develop(_even(luminance_nit), CAMERA, 3, settings_used).image_rgb
    linear = srgb_to_linear(image / 255.0)
    # What the code cannot tell apart is uniform over its width; its slope turns codes into electrons.
    code_e = np.interp(share, srgb_to_linear(np.arange(256) / 255), np.gradient(srgb_to_linear(np.arange(256) / 255)))
    code_e *= config.full_well_e / gain
    measured = linear * config.full_well_e / gain
    assert measured.mean() == pytest.approx(electrons, rel=0.01, abs=0.02 * code_e)
    expected = electrons + config.read_noise_e**2 + (code_e**2) / 12
    assert measured.var() == pytest.approx(expected, rel=0.06)


def test_picture_is_a_function_of_seed_and_frame_alone():
    radiance = np.random.default_rng(4).uniform(10, 9000, (240, 3, 320)).astype(np.float32)
    settings_used = SensorSettings(1e-3, 1.0)
    one, other = _sensor(1), _sensor(1)
    one.expose(radiance, CAMERA, 0)
    first = one.develop(radiance, CAMERA, 5, settings_used).image_rgb
    np.testing.assert_array_equal(first, other.develop(radiance, CAMERA, 5, settings_used).image_rgb)
    assert (first != one.develop(radiance, CAMERA, 6, settings_used).image_rgb).mean() > 0.5
    assert (first != _sensor(2).develop(radiance, CAMERA, 5, settings_used).image_rgb).mean() > 0.5


@given(st.floats(1.0, 4000.0))
@settings(max_examples=20, deadline=None)
def test_exposure_doubles_when_light_halves(luminance_nit):
    config = SensorConfig(longest_exposure_s=10.0)
    (bright_s, bright_gain), (dim_s, dim_gain) = (right_exposure(config, luminance_nit * share) for share in (1.0, 0.5))
    assert dim_s == pytest.approx(2 * bright_s)
    assert dim_gain == bright_gain == 1.0


def test_loop_converges_on_mid_grey_after_the_light_has_changed():
    sensor = _sensor(longest_exposure_s=0.01)
    sensor.expose(_even(4000.0), CAMERA, 0)
    levels = [srgb_to_linear(sensor.expose(_even(1000.0), CAMERA, k).image_rgb / 255.0).mean() for k in range(1, 20)]
    assert levels[0] == pytest.approx(0.18 / 4, rel=0.05)
    assert (np.diff(levels[:10]) > 0).all()
    assert levels[-1] == pytest.approx(0.18, rel=0.02)


def test_gain_rises_only_at_the_longest_exposure_and_both_have_limits():
    config = SensorConfig()
    for luminance_nit in np.geomspace(0.001, 1e6, 60):
        exposure_s, gain = right_exposure(config, luminance_nit)
        assert config.shortest_exposure_s <= exposure_s <= config.longest_exposure_s
        assert 1.0 <= gain <= config.largest_gain
        assert gain == 1.0 or exposure_s == config.longest_exposure_s
    assert right_exposure(config, 0.0)[1] == config.largest_gain


def test_settings_in_use_come_with_the_picture():
    sensor = _sensor()
    first = sensor.expose(_even(4000.0), CAMERA, 0)
    second = sensor.expose(_even(1000.0), CAMERA, 1)
    third = sensor.expose(_even(1000.0), CAMERA, 2)
    # The loop answers to a picture in the next one.
    assert first.settings.exposure_s == pytest.approx(second.settings.exposure_s)
    assert third.settings.exposure_s > 1.5 * second.settings.exposure_s


def test_meter_weighs_colours_as_the_eye_does():
    radiance = _even(0.0)
    radiance[:, 1] = 100.0
    assert luminance_of(metered_radiance(radiance)) == pytest.approx(71.52)


def test_tone_curve_is_srgb():
    np.testing.assert_allclose(srgb_to_linear(CODES / 255.0), np.arange(4096) / 4095, atol=0.0045)
    assert (CODES[0], CODES[-1]) == (0, 255)
    assert (np.diff(CODES.astype(int)) >= 0).all()


def test_bright_light_saturates():
    assert (_sensor().develop(_even(1e9), CAMERA, 0, SensorSettings(1e-3, 1.0)).image_rgb == 255).all()


def _point(width: int = 320, height: int = 240) -> np.ndarray:
    radiance = _even(0.0, width, height)
    radiance[120, :, 160] = 1000.0
    return radiance


@pytest.mark.parametrize("shift", [(12.0, 0.0), (0.0, -7.5), (9.0, 6.0)])
def test_motion_blur_draws_a_point_into_a_line_of_equal_light(shift):
    motion = np.eye(3)
    motion[:2, 2] = np.array(shift) / 0.5
    blurred = blur_by_motion(_point(), motion, 0.5)[:, 0]
    assert blurred.sum() == pytest.approx(1000.0, rel=0.01)
    row, column = np.nonzero(blurred > 20.0)
    extent = np.array([np.ptp(column), np.ptp(row)])
    np.testing.assert_allclose(extent, np.abs(shift), atol=1.6)
    centre = (blurred * np.arange(320)).sum() / blurred.sum(), (blurred * np.arange(240)[:, None]).sum() / blurred.sum()
    np.testing.assert_allclose(centre, (160, 120), atol=0.05)


def test_motion_below_half_a_pixel_leaves_the_picture_as_it_is():
    motion = np.eye(3)
    motion[0, 2] = 4.9
    radiance = _point()
    assert blur_by_motion(radiance, motion, 0.1) is radiance
    motion[2, 2] = -1.0
    with pytest.raises(ValueError, match="motion: expected a homography that keeps the picture before the camera"):
        blur_by_motion(radiance, motion, 0.1)


def test_scattered_light_is_kept_and_lies_evenly_on_what_is_dark():
    radiance = _even(0.0)
    radiance[:, :, 160:] = 800.0
    radiance[:, 2] *= 0.5
    share, even = np.float32(0.05), veil(metered_radiance(radiance), 0.05)
    np.testing.assert_allclose(even, (20.0, 20.0, 10.0), rtol=1e-5)
    scattered = np.empty_like(radiance)
    for row, into in zip(radiance, scattered, strict=True):
        scatter_row(row, share, even, into)
    np.testing.assert_allclose(scattered.mean(axis=(0, 2)), radiance.mean(axis=(0, 2)), rtol=1e-5)
    for channel, veil_nit in enumerate((20.0, 20.0, 10.0)):
        np.testing.assert_allclose(scattered[:, channel, :160], veil_nit, rtol=1e-5)
    hazy, clear = (CameraSensor(SensorConfig(veiling_glare=g), np.random.default_rng(0)) for g in (0.05, 0.0))
    settings = SensorSettings(1e-3, 1.0)
    np.testing.assert_array_equal(
        hazy.develop(radiance, CAMERA, 0, settings).image_rgb, clear.develop(scattered, CAMERA, 0, settings).image_rgb
    )
    assert (veil(metered_radiance(radiance), 0.0) == 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"shortest_exposure_s": 0.0}, "shortest_exposure_s: expected a number > 0, got 0.0"),
        ({"longest_exposure_s": 1e-9}, "longest_exposure_s: expected at least shortest_exposure_s"),
        ({"largest_gain": 0.5}, "largest_gain: expected a number >= 1, got 0.5"),
        ({"mid_grey": 1.0}, r"mid_grey: expected a number in \(0, 1\), got 1.0"),
        ({"adaptation": 0.0}, r"adaptation: expected a number in \(0, 1\], got 0.0"),
        ({"veiling_glare": 1.0}, r"veiling_glare: expected a number in \[0, 1\), got 1.0"),
        ({"white_balance": "warm"}, "white_balance: expected 'auto' or 'off', got warm"),
        ({"largest_colour_gain": 0.9}, "largest_colour_gain: expected a number >= 1, got 0.9"),
        ({"read_noise_e": float("nan")}, "read_noise_e: expected a number >= 0, got nan"),
    ],
)
def test_impossible_settings_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        SensorConfig(**options)
