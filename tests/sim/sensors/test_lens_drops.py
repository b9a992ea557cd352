"""Drops on the window: how many, where, that they run off, and what they do to a picture."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import Intrinsics
from sim.rng import generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.sensors.lens_drops import LensDrops, WetCameraSensor, draw_drops, see_through

CAMERA = Intrinsics(64, 48, 60.0)


def one_drop(x: float = 0.0, y: float = 0.0) -> LensDrops:
    return LensDrops(np.array([[x, y]]), np.array([0.3]), np.array([0.0]), np.array([2.0]), np.zeros(1))


def test_more_rain_brings_more_drops_and_none_brings_none():
    counts = [
        np.mean([len(draw_drops(rate, 20.0, 0.75, generator(seed, "drops")).radius) for seed in range(40)])
        for rate in (0.0, 2.0, 8.0)
    ]
    assert counts[0] == 0.0
    assert counts[2] == pytest.approx(2.0 * counts[1], rel=0.15)


def test_a_drop_lands_stays_and_runs_down():
    drop = one_drop()
    assert len(drop.at(-0.1)) == len(drop.at(5.0)) == 0
    np.testing.assert_array_equal(drop.at(0.1), drop.at(1.9))
    assert drop.at(2.5)[0, 1] > drop.at(2.2)[0, 1] > 0.0


def test_without_drops_the_picture_is_the_dry_one():
    radiance = np.random.default_rng(0).random((48, 3, 64), dtype=np.float32) * 100
    none = draw_drops(0.0, 10.0, 0.75, generator(0, "drops"))
    wet = WetCameraSensor(SensorConfig(), generator(1, "sensor"), none, CAMERA, 15.0)
    dry = CameraSensor(SensorConfig(), generator(1, "sensor"))
    np.testing.assert_array_equal(
        wet.expose(radiance.copy(), CAMERA, 3).image_rgb, dry.expose(radiance.copy(), CAMERA, 3).image_rgb
    )


def test_detail_is_lost_within_a_drop_and_kept_outside():
    rng = np.random.default_rng(0)
    sharp = rng.random((48, 3, 64), dtype=np.float32)
    seen = sharp.copy()
    see_through(seen, np.array([[32.0, 24.0, 12.0, 12.0]]), 4)
    assert seen[20:28, :, 28:36].std() < 0.4 * sharp[20:28, :, 28:36].std()
    np.testing.assert_array_equal(seen[:10], sharp[:10])


def test_a_plain_picture_keeps_its_light():
    plain = np.full((48, 3, 64), 7.0, np.float32)
    see_through(plain, np.array([[20.0, 24.0, 12.0, 9.0]]), 4)
    assert plain.mean() == pytest.approx(7.0, rel=0.01)
