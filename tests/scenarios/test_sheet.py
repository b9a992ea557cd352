"""The sheet under the dimmed bulb: the light is what it is said to be, and nothing depends on what it should not."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.stereo_follow.sheet import CONDITIONS, ILLUMINANCES_LX, SheetPicture, photograph


@pytest.fixture(scope="module")
def pictures() -> dict[str, list[SheetPicture]]:
    return {condition.name: list(photograph(condition, 7)) for condition in CONDITIONS}


def test_the_sheet_is_lit_as_the_paper_says(pictures):
    for taken in pictures.values():
        np.testing.assert_allclose([p.illuminance_lx for p in taken], ILLUMINANCES_LX)


def test_the_region_shows_the_sheet(pictures):
    first = pictures["I"][0]
    left, top, right, bottom = first.region_xyxy.astype(int)
    inside = first.image_rgb[top:bottom, left:right].astype(int)
    assert inside.shape[0] > 60
    assert inside.shape[1] > 90
    red, green, blue = inside.transpose(2, 0, 1)
    assert ((green > red + 15) & (green > blue + 5)).mean() > 0.99
    wall = first.image_rgb[top:bottom, :30].astype(int)
    # Nearly the whole picture is wall: white balance makes that grey.
    assert np.ptp(wall.mean(axis=(0, 1))) < 12


def test_what_is_fixed_stays_as_at_the_brightest_and_the_rest_follows(pictures):
    at = {name: [p.registers for p in taken] for name, taken in pictures.items()}
    assert at["I"][0] == at["II"][0] == at["III"][0]
    assert len({(r.shutter, r.gain) for r in at["II"]}) == 1
    assert len({(r.red, r.blue) for r in at["III"]}) == 1
    for name in ("I", "III"):
        products = [r.shutter * 10 ** (24 * r.gain / 683 / 20) for r in at[name]]
        assert (np.diff(products) > 0).all()
    for name in ("I", "II"):
        # The dimmer the redder: less gain for red, more for blue until it can do no more.
        assert (np.diff([r.red for r in at[name]]) < 0).all()
        assert (np.diff([r.blue for r in at[name]]) >= 0).all()


def test_a_fixed_exposure_lets_the_picture_go_dark_and_an_automatic_one_does_not(pictures):
    def level(name: str) -> list[float]:
        return [float(p.image_rgb.mean()) for p in pictures[name]]

    assert level("II")[-1] < 0.2 * level("II")[0]
    assert level("I")[-1] == pytest.approx(level("I")[0], rel=0.15)


def test_pictures_are_a_function_of_the_seed(pictures):
    again = list(photograph(CONDITIONS[0], 7))
    for one, other in zip(pictures["I"], again, strict=True):
        np.testing.assert_array_equal(one.image_rgb, other.image_rgb)
    another = next(photograph(CONDITIONS[0], 8))
    assert (another.image_rgb != again[0].image_rgb).mean() > 0.5


def test_both_renderers_show_the_same(pictures):
    drawn = next(photograph(CONDITIONS[0], 7, "pybullet"))
    difference = np.abs(drawn.image_rgb.astype(int) - pictures["I"][0].image_rgb)
    # Textures are sampled with and without mip-maps: grain differs by a code or two, the sheet's edge by more.
    assert (difference.max(axis=2) > 8).mean() < 0.01
    for name in ("red", "blue", "shutter", "gain"):
        assert abs(getattr(drawn.registers, name) - getattr(pictures["I"][0].registers, name)) <= 1
