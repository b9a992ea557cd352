"""The drive with the sheet: a way without jumps, through corridors that are closed, in light that changes."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from scenarios.stereo_follow import carried_sheet
from scenarios.stereo_follow.carried_sheet import FRAMES, drive


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
def some() -> list[carried_sheet.CarriedPicture]:
    """Every 40th picture of a drive, until it is round the corner."""
    return list(islice(drive(3), 0, 620, 40))


def test_walls_are_closed_and_the_sheet_stays_where_it_is(some):
    for picture in some:
        np.testing.assert_allclose(picture.region_xyxy, some[0].region_xyxy, atol=1e-6)
        # A hole in a wall would be black in all channels, which scattered light is not.
        assert (picture.image_rgb.max(axis=2) == 0).mean() < 0.001


def test_back_light_shortens_the_exposure_and_shade_asks_for_gain(some):
    window, shade = some[12].registers, some[15].registers
    assert window.shutter < 150
    assert window.gain == 0
    assert shade.shutter == 707
    assert shade.gain > 0


def test_hue_hardly_changes_where_value_does(some):
    means = np.array([_inside(picture).mean(axis=(0, 1)) for picture in some])
    green = means[:, 1] > np.maximum(means[:, 0], means[:, 2])
    assert green.all()
    assert means[:, 1].max() > 3 * means[:, 1].min()


def test_drives_are_a_function_of_the_seed_alone(some):
    again = next(drive(3))
    np.testing.assert_array_equal(again.image_rgb, some[0].image_rgb)
    assert (next(drive(4)).image_rgb != again.image_rgb).mean() > 0.5


def test_both_renderers_show_the_same(some):
    drawn = next(drive(3, "pybullet")).image_rgb.astype(int)
    difference = np.abs(drawn - some[0].image_rgb).max(axis=2)
    # Edges of doors and lights are sampled alike up to a pixel; grain is interpolated in one and not in the other.
    assert (difference > 12).mean() < 0.02


def _inside(picture: carried_sheet.CarriedPicture) -> np.ndarray:
    left, top, right, bottom = picture.region_xyxy.astype(int)
    return picture.image_rgb[top:bottom, left:right].astype(float)
