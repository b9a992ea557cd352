"""The drive with the sheet: a way without jumps, through corridors that are closed, in light that changes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import cv2
import numpy as np
import pytest

from scenarios.stereo_follow import carried_sheet
from scenarios.stereo_follow.camera import camera, camera_pose
from scenarios.stereo_follow.carried_sheet import FRAMES, drive
from sim.optics import PinholeCamera
from sim.render.protocol import create_renderer
from sim.world import World


def test_the_way_is_even_and_turns_once_to_the_left():
    places, headings = (np.array(each) for each in zip(*carried_sheet._way(), strict=True))
    assert len(places) == FRAMES == 947
    steps_m = np.linalg.norm(np.diff(places, axis=0), axis=1)
    # 0.6 m/s, as a robot drives indoors; a chord is a little shorter than its arc.
    np.testing.assert_allclose(steps_m * 15.0, steps_m[0] * 15.0, rtol=0.002)
    assert 0.5 < steps_m[0] * 15.0 < 0.8
    moved = np.arctan2(*np.diff(places, axis=0).T[::-1])
    np.testing.assert_allclose(moved, 0.5 * (headings[1:] + headings[:-1]), atol=0.03)
    assert headings[0] == 0.0
    assert headings[-1] == pytest.approx(0.5 * np.pi)
    assert (np.diff(headings) >= 0).all()


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    with World() as built:
        carried_sheet._build(built, np.random.default_rng(0))
        yield built


def _views(count: int) -> Iterator[tuple[PinholeCamera, np.ndarray]]:
    """Views on the way, also to the sides."""
    way = list(carried_sheet._way())
    for k in np.linspace(0, len(way) - 1, count).astype(int):
        place_m, heading_rad = way[k]
        for turned in (-1.2, 0.0, 1.2, np.pi):
            yield camera(160, 120), camera_pose(place_m, heading_rad + turned)


def test_there_is_no_hole_in_the_building(world):
    renderer = create_renderer("raster", world)
    for view in _views(25):
        assert np.isfinite(renderer.gbuffer(*view).depth_m).all()


def test_both_renderers_show_the_same_building(world):
    raster, reference = (create_renderer(name, world) for name in ("raster", "pybullet"))
    for view in _views(6):
        one, other = raster.gbuffer(*view), reference.gbuffer(*view)
        assert (one.instance_id != other.instance_id).mean() < 0.003


@pytest.fixture(scope="module")
def some() -> list[carried_sheet.CarriedPicture]:
    """Every 20th picture of a drive, until it is well round the corner."""
    return list(islice(drive(3), 0, 620, 20))


def test_the_sheet_stays_where_it_is(some):
    for picture in some:
        np.testing.assert_allclose(picture.region_xyxy, some[0].region_xyxy, atol=1e-6)


def test_back_light_shortens_the_exposure_and_shade_asks_for_gain(some):
    against_light = min(picture.registers.shutter for picture in some)
    assert against_light < 150
    (frame,) = {20 * k for k, picture in enumerate(some) if picture.registers.shutter == against_light}
    assert 340 < frame < 420
    # The lights are off there: the sheet is darker than anywhere under lights, between two of them too.
    assert some[-1].illuminance_lx < 0.8 * min(picture.illuminance_lx for picture in some[:15])
    assert some[-1].registers.shutter == 707
    assert some[-1].registers.gain > 200


def test_hue_hardly_changes_where_value_does(some):
    hsv = np.array([cv2.cvtColor(_inside(picture), cv2.COLOR_RGB2HSV).mean(axis=(0, 1)) for picture in some])
    assert (2 * hsv[:, 0]).std() < 15.0
    assert hsv[:, 2].max() > 3 * hsv[:, 2].min()


def test_drives_are_a_function_of_the_seed_alone(some):
    again = next(drive(3))
    np.testing.assert_array_equal(again.image_rgb, some[0].image_rgb)
    assert (next(drive(4)).image_rgb != again.image_rgb).mean() > 0.5


def _inside(picture: carried_sheet.CarriedPicture) -> np.ndarray:
    left, top, right, bottom = picture.region_xyxy.astype(int)
    return np.ascontiguousarray(picture.image_rgb[top:bottom, left:right])
