"""The white-balance loop: grey cards come out grey, within limits, and stay as they are when held."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.optics import PinholeCamera
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig, SensorSettings
from sim.sensors.registers import LONGEST_EXPOSURE_S, STEREO_SENSOR, Registers, registers
from sim.sensors.white_balance import next_gains, right_gains
from sim.shaders.black_body import black_body_rgb

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


def test_registers_reach_the_ends_of_the_papers_ranges():
    assert registers(SensorSettings(LONGEST_EXPOSURE_S, STEREO_SENSOR.largest_gain, 4.0, 4.0)) == Registers(
        1023, 1023, 707, 683
    )
    assert registers(SensorSettings(0.0, 1.0, 0.25, 0.25)) == Registers(0, 0, 0, 0)
    assert registers(SensorSettings(0.5 * LONGEST_EXPOSURE_S, STEREO_SENSOR.largest_gain**0.5)) == Registers(
        512, 512, 354, 342
    )


@given(st.floats(1e-4, 1e5), st.floats(1800.0, 6500.0))
@settings(max_examples=40, deadline=None)
def test_registers_stay_in_range_and_gain_waits_for_the_shutter(luminance_nit, temperature_k):
    sensor = CameraSensor(STEREO_SENSOR, np.random.default_rng(0))
    now = registers(sensor.settings_for(luminance_nit * black_body_rgb(temperature_k)))
    for value, largest in ((now.red, 1023), (now.blue, 1023), (now.shutter, 707), (now.gain, 683)):
        assert 0 <= value <= largest
    assert now.gain == 0 or now.shutter == 707
