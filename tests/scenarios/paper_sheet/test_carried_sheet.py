"""The drive with the sheet: a path without jumps, through closed corridors, in changing light."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace

import cv2
import numpy as np
import pytest

from scenarios.paper_sheet import carried_sheet
from scenarios.paper_sheet.scenario import PAPER_SHEET, SheetEpisode
from scenarios.paper_sheet.sheet import region_of_sheet
from scenarios.scenario import Frame, Setup
from scenarios.stereo_follow.camera import camera, camera_pose
from sim.render.protocol import create_renderer
from sim.world import World
from trackers.types import CameraModel

FRAMES = 947


def test_the_way_is_even_and_turns_once_to_the_left():
    places, headings = (np.array(each) for each in zip(*carried_sheet._way(FRAMES), strict=True))
    assert len(places) == FRAMES
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
    built = World()
    carried_sheet._build(built, np.random.default_rng(0))
    return built


def _views(count: int) -> Iterator[tuple[CameraModel, np.ndarray]]:
    """Views along the path, also to the sides."""
    way = list(carried_sheet._way(FRAMES))
    for k in np.linspace(0, len(way) - 1, count).astype(int):
        place_m, heading_rad = way[k]
        for turned in (-1.2, 0.0, 1.2, np.pi):
            yield camera(160, 120), camera_pose(place_m, heading_rad + turned)


@pytest.mark.heavy
def test_there_is_no_hole_in_the_building(world):
    renderer = create_renderer("raster", world)
    for view in _views(25):
        assert np.isfinite(renderer.gbuffer(*view).depth_m).all()


@pytest.mark.heavy
def test_both_renderers_show_the_same_building(world):
    raster, reference = (create_renderer(name, world) for name in ("raster", "pybullet"))
    for view in _views(6):
        one, other = raster.gbuffer(*view), reference.gbuffer(*view)
        assert (one.instance_id != other.instance_id).mean() < 0.003


@pytest.fixture(scope="module")
def some() -> list[Frame]:
    """Return every 20th frame of a drive with small pictures, until well past the corner."""
    preset = replace(PAPER_SHEET.presets["paper-b2"], width_px=160, height_px=120)
    with closing(SheetEpisode(Setup(PAPER_SHEET, preset, 3))) as episode:
        return [frame for frame in (episode.step() for _ in range(620)) if frame.truth.frame % 20 == 0]


def _region(frame: Frame) -> np.ndarray:
    return region_of_sheet(frame.camera, frame.truth.T_world_camera, frame.truth.T_world_object[0])


@pytest.mark.heavy
def test_the_sheet_stays_where_it_is(some):
    for frame in some:
        np.testing.assert_allclose(_region(frame), _region(some[0]), atol=1e-6)
        np.testing.assert_allclose(frame.truth.box_xyxy, some[0].truth.box_xyxy, atol=1e-3)
        # The sheet is 1.6 m ahead and moves faster than the robot round the corner.
        assert 0.5 < frame.truth.speed_mps[0] < 3.0


@pytest.mark.heavy
def test_back_light_shortens_the_exposure_and_shade_asks_for_gain(some):
    registers = [frame.truth.registers for frame in some]
    against_light = min(each.shutter for each in registers)
    assert against_light < 150
    (frame,) = {20 * k for k, each in enumerate(registers) if each.shutter == against_light}
    assert 340 < frame < 420
    assert "back light" in {each.truth.light_event for each in some[:22]}
    # The lights are off there: the sheet is darker than anywhere under lights, between two of them too.
    lit_lx = [each.truth.illuminance_lx[0] for each in some]
    assert lit_lx[-1] < 0.8 * min(lit_lx[:15])
    assert registers[-1].shutter == 707
    assert registers[-1].gain > 200


@pytest.mark.heavy
def test_hue_hardly_changes_where_value_does(some):
    hsv = np.array([cv2.cvtColor(_inside(frame), cv2.COLOR_RGB2HSV).mean(axis=(0, 1)) for frame in some])
    assert (2 * hsv[:, 0]).std() < 15.0
    assert hsv[:, 2].max() > 3 * hsv[:, 2].min()


def _inside(frame: Frame) -> np.ndarray:
    left, top, right, bottom = _region(frame).astype(int)
    return np.ascontiguousarray(frame.observation.image_rgb[top:bottom, left:right])
