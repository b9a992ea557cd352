"""The white-balance loop: grey cards come out grey, within limits, and stay as they are when held."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.optics import PinholeCamera
from sim.sensors.automatic import channel_gains, next_gains, right_gains
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.colour import black_body_rgb, srgb_to_linear

CAMERA = PinholeCamera(160, 120, 150.0)


def _card(temperature_k: float, luminance_nit: float) -> np.ndarray:
    """A grey card that fills the picture, under a lamp."""
    radiance = np.empty((120, 3, 160), np.float32)
    radiance[:] = (luminance_nit * black_body_rgb(temperature_k))[None, :, None]
    return radiance


def _sensor(**options) -> CameraSensor:
    return CameraSensor(SensorConfig(white_balance="auto", **options), np.random.default_rng(0))


@pytest.mark.parametrize("temperature_k", [2300.0, 2850.0, 4000.0, 6500.0, 9000.0])
def test_a_grey_card_comes_out_grey(temperature_k):
    image = _sensor().expose(_card(temperature_k, 500.0), CAMERA, 0).image_rgb
    mean = image.mean(axis=(0, 1))
    np.testing.assert_allclose(mean, mean[1], atol=1.0)


def test_without_it_warm_light_looks_warm():
    sensor = CameraSensor(SensorConfig(), np.random.default_rng(0))
    red, green, blue = sensor.expose(_card(2850.0, 500.0), CAMERA, 0).image_rgb.mean(axis=(0, 1))
    assert red > green + 20
    assert green > blue + 20


def test_the_loop_follows_a_change_of_light_step_by_step():
    sensor = _sensor(adaptation=0.2)
    sensor.expose(_card(6500.0, 500.0), CAMERA, 0)
    pictures = [sensor.expose(_card(2850.0, 500.0), CAMERA, k).image_rgb.mean(axis=(0, 1)) for k in range(1, 40)]
    warmth = np.array([red - blue for red, _, blue in pictures])
    assert warmth[0] > 40
    assert (np.diff(warmth[:10]) < 0).all()
    assert abs(warmth[-1]) < 1.5


@given(st.floats(1e-3, 1e5), st.floats(1e-3, 1e5), st.floats(1e-3, 1e5))
def test_gains_stay_within_their_limits_and_rest_where_they_are_right(red, green, blue):
    config = SensorConfig(white_balance="auto", largest_colour_gain=3.0)
    gains = right_gains(config, np.array([red, green, blue]))
    assert all(1 / 3 <= gain <= 3 for gain in gains)
    assert next_gains(config, *gains, np.array([red, green, blue])) == pytest.approx(gains)


@pytest.mark.parametrize("held", ["exposure", "white_balance"])
def test_what_is_held_stays_and_the_other_goes_on(held):
    sensor = _sensor(longest_exposure_s=1.0)
    before = sensor.expose(_card(6500.0, 500.0), CAMERA, 0).settings
    sensor.hold(exposure=held == "exposure", white_balance=held == "white_balance")
    for frame in range(1, 30):
        after = sensor.expose(_card(2850.0, 50.0), CAMERA, frame).settings
    same_exposure = (after.exposure_s, after.gain) == pytest.approx((before.exposure_s, before.gain))
    same_gains = (after.red_gain, after.blue_gain) == pytest.approx((before.red_gain, before.blue_gain))
    assert (same_exposure, same_gains) == (held == "exposure", held == "white_balance")


def test_off_means_no_gains():
    assert right_gains(SensorConfig(), np.array([1.0, 2.0, 3.0])) == (1.0, 1.0)


@pytest.mark.parametrize("temperature_k", [2300.0, 2850.0, 9000.0])
def test_what_is_too_bright_is_white_in_light_of_any_colour(temperature_k):
    sensor = _sensor(longest_exposure_s=0.01)
    sensor.expose(_card(temperature_k, 100.0), CAMERA, 0)
    assert (sensor.expose(_card(temperature_k, 1e5), CAMERA, 1).image_rgb == 255).all()


@given(st.floats(0.25, 4.0), st.floats(0.25, 4.0))
def test_no_channel_is_weakened_and_their_ratios_are_the_gains(red_gain, blue_gain):
    gains = channel_gains(red_gain, blue_gain)
    assert min(gains) == pytest.approx(1.0)
    assert (gains[0] / gains[1], gains[2] / gains[1]) == pytest.approx((red_gain, blue_gain))


@pytest.mark.parametrize("temperature_k", [2300.0, 2850.0, 9000.0])
def test_a_card_is_brought_to_mid_grey_in_light_of_any_colour(temperature_k):
    sensor = _sensor(longest_exposure_s=1.0)
    image = sensor.expose(_card(temperature_k, 500.0), CAMERA, 0).image_rgb
    # All channels are made as bright as green, of which coloured light of one luminance has more or less.
    green = black_body_rgb(temperature_k)[1]
    assert srgb_to_linear(image / 255.0).mean() == pytest.approx(sensor.config.mid_grey * green, rel=0.02)
