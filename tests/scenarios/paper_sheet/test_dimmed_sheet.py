"""The sheet under the dimmed bulb: the light is as configured, and nothing else changes."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from scenarios.paper_sheet.dimmed_sheet import DimmedSheet
from scenarios.paper_sheet.scenario import PAPER_SHEET, SheetEpisode
from scenarios.paper_sheet.sheet import region_of_sheet
from scenarios.scenario import Frame, RendererName, Setup

PRESET = PAPER_SHEET.presets["paper-b1"]
SEED = 7


def frames_of(
    preset: DimmedSheet = PRESET, seed: int = SEED, renderer: RendererName = "raster", **held: bool
) -> list[Frame]:
    """Return all frames; ``held`` settings stay as on the first one."""
    with closing(SheetEpisode(Setup(PAPER_SHEET, preset, seed, renderer))) as episode:
        frames = []
        for _ in range(episode.frame_count):
            frames.append(episode.step())
            episode.hold(**({"exposure": False, "white_balance": False} | held))
        return frames


@pytest.fixture(scope="module")
def taken() -> dict[str, list[Frame]]:
    """Return the frames with all automatic, with exposure held, and with white balance held."""
    held = {"auto": {}, "exposure": {"exposure": True}, "white balance": {"white_balance": True}}
    return {name: frames_of(**options) for name, options in held.items()}


def registers(frames: list[Frame]):
    return [frame.truth.registers for frame in frames]


@pytest.mark.heavy
def test_the_sheet_is_lit_as_the_paper_says(taken):
    for frames in taken.values():
        lit_lx = [frame.truth.illuminance_lx[0] for frame in frames]
        np.testing.assert_allclose(lit_lx, (609, 533, 414, 311, 203, 122, 86, 38, 19))


@pytest.mark.heavy
def test_the_region_shows_the_sheet(taken):
    first = taken["auto"][0]
    truth, image = first.truth, first.observation.image_rgb
    region = region_of_sheet(first.camera, truth.T_world_camera, truth.T_world_object[0])
    left, top, right, bottom = region.astype(int)
    assert (truth.instance_map[top:bottom, left:right] == truth.instance_id[0]).all()
    assert bottom - top > 60
    assert right - left > 90
    red, green, blue = image[top:bottom, left:right].astype(int).transpose(2, 0, 1)
    assert ((green > red + 15) & (green > blue + 5)).mean() > 0.99
    wall = image[top:bottom, :30].astype(int)
    # Nearly the whole picture is wall; white balance makes it grey.
    assert np.ptp(wall.mean(axis=(0, 1))) < 12


@pytest.mark.heavy
def test_what_is_held_stays_as_at_the_brightest_and_the_rest_follows(taken):
    at = {name: registers(frames) for name, frames in taken.items()}
    assert at["auto"][0] == at["exposure"][0] == at["white balance"][0]
    assert len({(r.shutter, r.gain) for r in at["exposure"]}) == 1
    assert len({(r.red, r.blue) for r in at["white balance"]}) == 1
    for name in ("auto", "white balance"):
        products = [r.shutter * 10 ** (24 * r.gain / 683 / 20) for r in at[name]]
        assert (np.diff(products) > 0).all()
    for name in ("auto", "exposure"):
        # Dimmer light is redder: less gain for red, more for blue up to its limit.
        assert (np.diff([r.red for r in at[name]]) < 0).all()
        assert (np.diff([r.blue for r in at[name]]) >= 0).all()


def test_a_held_exposure_lets_the_picture_go_dark_and_an_automatic_one_does_not(taken):
    def level(name: str) -> list[float]:
        return [float(frame.observation.image_rgb.mean()) for frame in taken[name]]

    assert level("exposure")[-1] < 0.2 * level("exposure")[0]
    assert level("auto")[-1] == pytest.approx(level("auto")[0], rel=0.15)


@pytest.mark.heavy
def test_the_loops_have_come_to_rest_on_every_picture(taken):
    """If an illuminance is given twice, the second picture has the settings of the first."""
    twice = frames_of(replace(PRESET, illuminances_lx=tuple(np.repeat(PRESET.illuminances_lx, 2))))
    for first, second in zip(twice[::2], twice[1::2], strict=True):
        assert first.truth.exposure_s == pytest.approx(second.truth.exposure_s, rel=1e-4)
        assert first.truth.gain == pytest.approx(second.truth.gain, rel=1e-4)


@pytest.mark.heavy
def test_both_renderers_show_the_same(taken):
    drawn, first = frames_of(replace(PRESET, illuminances_lx=(609.0,)), renderer="pybullet")[0], taken["auto"][0]
    difference = np.abs(drawn.observation.image_rgb.astype(int) - first.observation.image_rgb)
    # Textures are sampled with and without mip-maps: grain differs by a code or two, the sheet's edge by more.
    assert (difference.max(axis=2) > 8).mean() < 0.01
    for name in ("red", "blue", "shutter", "gain"):
        assert abs(getattr(drawn.truth.registers, name) - getattr(first.truth.registers, name)) <= 1


def test_light_that_is_none_is_refused():
    with pytest.raises(
        ValueError, match=r"illuminances_lx: expected one or more numbers in \(0, 120000\], got \(609.0, 0.0\)"
    ):
        DimmedSheet("dark", illuminances_lx=(609.0, 0.0))
