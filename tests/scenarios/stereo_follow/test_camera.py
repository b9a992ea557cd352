"""The stereo camera's registers cover the paper's ranges."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.stereo_follow.camera import LONGEST_EXPOSURE_S, SENSOR, registers
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorSettings
from sim.shaders.colour import black_body_rgb
from trackers.types import CameraRegisters


def test_registers_reach_the_ends_of_the_papers_ranges():
    most = SENSOR.largest_colour_gain
    assert registers(SensorSettings(LONGEST_EXPOSURE_S, SENSOR.largest_gain, most, most)) == CameraRegisters(
        1023, 1023, 707, 683
    )
    assert registers(SensorSettings(0.0, 1.0, 1 / most, 1 / most)) == CameraRegisters(0, 0, 0, 0)
    assert registers(SensorSettings(0.5 * LONGEST_EXPOSURE_S, SENSOR.largest_gain**0.5)) == CameraRegisters(
        512, 512, 354, 342
    )


@given(st.floats(1e-4, 1e5), st.floats(1800.0, 6500.0))
@settings(max_examples=40, deadline=None)
def test_registers_stay_in_range_and_gain_waits_for_the_shutter(luminance_nit, temperature_k):
    sensor = CameraSensor(SENSOR, np.random.default_rng(0))
    now = registers(sensor.settings_for(luminance_nit * black_body_rgb(temperature_k)))
    for value, largest in ((now.red, 1023), (now.blue, 1023), (now.shutter, 707), (now.gain, 683)):
        assert 0 <= value <= largest
    assert now.gain == 0 or now.shutter == 707
