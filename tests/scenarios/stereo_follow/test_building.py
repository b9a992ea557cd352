"""Rooms are closed, panels face their viewers, and clothes are alike as configured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from scenarios.catalog import scenario
from scenarios.stereo_follow import panels
from scenarios.stereo_follow.building import (
    CORRIDOR_LIGHTS,
    HALL_LIGHTS,
    LIGHT_GROUPS,
    WINDOWS,
    Building,
    draw_building,
)
from scenarios.stereo_follow.floor_plan import Area, draw_floor_plan
from scenarios.stereo_follow.panels import Panel, box, wall
from scenarios.stereo_follow.plan import draw_looks, make_plan, of_many_builds
from scenarios.stereo_follow.presets import PRESETS
from sim.mesh import Texture

GREY = Texture(np.full((4, 4, 3), 128, np.uint8))
SEEDS = st.integers(0, 10_000)
RATE_HZ = 15.0


@lru_cache(maxsize=8)
def building_of(seed: int) -> Building:
    return draw_building(draw_floor_plan(np.random.default_rng(seed)), np.random.default_rng(seed))


def first_panels(
    panels: Sequence[Panel], origin_m: NDArray[np.float64], directions: NDArray[np.float64], *, facing: bool
) -> NDArray[np.float64]:
    """Return distances (N,) along rays (N, 3) to the first panel, inf for none; of facing panels, or of all."""
    corners, a, b = (np.array([getattr(p, name) for p in panels]) for name in ("corner_m", "side_a_m", "side_b_m"))
    normals = np.cross(a, b)
    towards = directions @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        distance_m = np.einsum("pk,pk->p", corners - origin_m, normals) / towards
        at_m = origin_m + distance_m[..., None] * directions[:, None] - corners
    u, v = (np.einsum("npk,pk->np", at_m, side) / np.einsum("pk,pk->p", side, side) for side in (a, b))
    hit = (distance_m > 1e-6) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1) & ((towards < 0) | (not facing))
    return np.where(hit, distance_m, np.inf).min(axis=1)


def rays_about(rng: np.random.Generator, count: int = 300) -> NDArray[np.float64]:
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.mark.heavy
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 5), place=st.tuples(st.floats(0, 1), st.floats(0, 1), st.floats(0.1, 1.4)))
def test_rooms_are_closed_and_everything_seen_from_them_faces_them(seed, place):
    building = building_of(seed)
    plan, rng = building.plan, np.random.default_rng(seed)
    for room in ("corridor", "hall", "yard"):
        area = plan.free_area(room)
        x, y, z = place
        eye_m = np.array([area.x0 + x * (area.x1 - area.x0), area.y0 + y * (area.y1 - area.y0), z])
        directions = rays_about(rng)
        distance_m = first_panels(building.panels, eye_m, directions, facing=True)
        # No back of a panel, which is not drawn, hides a visible panel.
        nearest_m = first_panels(building.panels, eye_m, directions, facing=False)
        np.testing.assert_allclose(nearest_m, distance_m, rtol=1e-6)
        sky = np.isinf(distance_m)
        if room == "yard":
            assert not sky[directions[:, 2] < 0].any()
            assert sky.mean() > 0.15
        else:
            at_door_m = eye_m + directions * ((plan.door.x0 - eye_m[0]) / directions[:, :1])
            through = (directions[:, 0] > 0) & (at_door_m[:, 1] > plan.door.y0) & (at_door_m[:, 1] < plan.door.y1)
            assert not (sky & ~(through & (at_door_m[:, 2] < plan.opening_height_m))).any()


@settings(max_examples=30, deadline=None)
@given(
    start=st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
    angle=st.floats(0, 6.3),
    length=st.floats(2.0, 20.0),
    opening=st.one_of(st.none(), st.tuples(st.floats(0.0, 0.4), st.floats(0.5, 1.0), st.floats(0.5, 3.0))),
)
def test_a_wall_faces_right_and_has_its_area_without_the_opening(start, angle, length, opening):
    along = np.array([np.cos(angle), np.sin(angle)])
    end = tuple(np.array(start) + length * along)
    hole = None if opening is None else (opening[0] * length, opening[1] * length, opening[2])
    pieces = list(wall("wall", start, end, 3.0, GREY, hole, offset_m=0.1))
    normals = [np.cross(piece.side_a_m, piece.side_b_m) for piece in pieces]
    right = np.array([along[1], -along[0], 0.0])
    for piece, normal in zip(pieces, normals, strict=True):
        assert normal / np.linalg.norm(normal) == pytest.approx(right, abs=1e-6)
        assert (piece.corner_m[:2] - start) @ right[:2] == pytest.approx(0.1, abs=1e-9)
    missing = 0.0 if hole is None else (hole[1] - hole[0]) * hole[2]
    assert sum(np.linalg.norm(normal) for normal in normals) == pytest.approx(3.0 * length - missing, abs=1e-4)


def test_a_box_faces_outward_everywhere():
    pieces = list(box("box", (1.0, 2.0), (0.8, 0.4, 1.2), GREY))
    middle_m = np.array([1.0, 2.0, 0.6])
    assert len(pieces) == 5
    for piece in pieces:
        centre_m = piece.corner_m + 0.5 * (piece.side_a_m + piece.side_b_m)
        assert np.cross(piece.side_a_m, piece.side_b_m) @ (centre_m - middle_m) > 0
    directions = rays_about(np.random.default_rng(0))
    assert np.isinf(first_panels(pieces, middle_m, directions, facing=True)).all()
    assert np.isfinite(first_panels(pieces, middle_m, directions, facing=False)).sum() > 250


@pytest.mark.parametrize("seed", range(3))
def test_what_shines_belongs_to_a_group_and_hangs_in_its_room(seed):
    building = building_of(seed)
    plan = building.plan
    rooms = {CORRIDOR_LIGHTS: plan.corridor, HALL_LIGHTS: plan.hall}
    shining = [panel for panel in building.panels if panel.luminance_nit > 0]
    assert {panel.group for panel in shining} == {CORRIDOR_LIGHTS, HALL_LIGHTS, WINDOWS}
    for panel in building.panels:
        assert (panel.group in LIGHT_GROUPS) == (panel.luminance_nit > 0)
        if panel.group in rooms:
            centre_m = panel.corner_m + 0.5 * (panel.side_a_m + panel.side_b_m)
            assert rooms[panel.group].holds(centre_m[:2])
            assert np.cross(panel.side_a_m, panel.side_b_m)[2] < 0
    assert np.linalg.norm(building.sky.sun_direction) == pytest.approx(1.0)
    assert building.sky.sun_direction[2] > 0.4


@pytest.mark.parametrize("seed", range(3))
def test_nothing_stands_where_people_go(seed):
    building = building_of(seed)
    free = [(building.plan.free_area(room)) for room in building.plan.rooms]
    for panel in building.panels:
        upright = abs(np.cross(panel.side_a_m, panel.side_b_m)[2]) < 1e-6
        if upright and panel.corner_m[2] < 1.8:
            along = np.linspace(0.0, 1.0, 40)[:, None]
            foot_m = (panel.corner_m + along * panel.side_a_m)[:, :2]
            assert not any(area.shrunk(0.15).holds(foot_m).any() for area in free), panel.name
    for _, pose in building.trees:
        assert not any(area.holds(pose[:2, 3]) for area in free)


def test_surfaces_are_textures_of_the_colour_asked_for():
    rng = np.random.default_rng(0)
    for texture in (
        panels.tiled((120, 90, 60), (4.0, 2.0), (0.5, 0.25), rng),
        panels.stained((120, 90, 60), (4.0, 2.0), rng),
        panels.leafy((120, 90, 60), (4.0, 2.0), rng),
    ):
        rows, columns = texture.rgb.shape[:2]
        assert columns == pytest.approx(2 * rows, abs=2)
        assert texture.rgb.reshape(-1, 3).mean(axis=0) == pytest.approx([120, 90, 60], rel=0.15)
        assert texture.rgb.std(axis=(0, 1)).min() > 1.0
    for texture in (panels.poster((0.8, 0.5), rng), panels.door_leaf((90, 80, 70), rng), panels.pane(rng)):
        assert texture.rgb.dtype == np.uint8


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, alike=st.integers(0, 4))
def test_as_many_are_dressed_alike_as_told_and_nobody_else(seed, alike):
    target, *others = draw_looks(8, alike, 0, np.random.default_rng(seed))
    differs = [np.abs(np.subtract(other.top_rgb, target.top_rgb)).max() for other in others]
    assert all(difference < 45 for difference in differs[:alike])
    assert all(difference > 10 for difference in differs[alike:])
    assert alike == 0 or np.median(differs[alike:]) > 1.5 * np.median(differs[:alike])
    if alike:
        assert np.abs(np.subtract(others[0].legwear_rgb, target.legwear_rgb)).max() < 40
        assert others[0].legwear == target.legwear
    for look in (target, *others):
        assert 1.5 < look.stature_m < 1.95


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, uniformed=st.integers(0, 7))
def test_who_is_in_uniform_wears_what_the_target_wears(seed, uniformed):
    target, *others = draw_looks(8, 0, uniformed, np.random.default_rng(seed))
    clothes = [(look.top_rgb, look.sleeves, look.legwear, look.legwear_rgb) for look in (target, *others)]
    assert all(worn == clothes[0] for worn in clothes[: uniformed + 1])
    assert all(worn != clothes[0] for worn in clothes[uniformed + 1 :])
    statures_m = [look.stature_m for look in others if 1.52 < look.stature_m < 1.93]
    assert len(set(statures_m)) == len(statures_m), "but for the limits, at which two may be cut"


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, alike=st.integers(0, 4), uniformed=st.sampled_from([0, 5]))
def test_who_is_dressed_alike_remains_so_whatever_the_build(seed, alike, uniformed):
    looks = draw_looks(8, alike, uniformed, np.random.default_rng(seed))
    made = of_many_builds(looks, alike, uniformed, np.random.default_rng(seed + 1))
    assert [(look.top_rgb, look.legwear_rgb) for look in made] == [(look.top_rgb, look.legwear_rgb) for look in looks]
    assert len({(look.stature_m, look.figure) for look in made}) == len(made)
    if alike:
        assert (made[1].legwear, made[1].top_length) == (made[0].legwear, made[0].top_length)
    if uniformed:
        cuts = {(look.sleeves, look.legwear, look.top_length, look.top_pattern) for look in made[: uniformed + 1]}
        assert cuts == {("long", "trousers", "hip", "plain")}


def test_the_papers_experiment_has_as_many_frames():
    paper = PRESETS["paper-b3"]
    assert paper.frame_count == 853
    assert 10 * paper.frame_count == 8_530
    assert (paper.width_px, paper.height_px) == (640, 480)


@pytest.mark.parametrize(
    ("nonsense", "message"),
    [
        (
            {"frame_count": 1},
            r"frame_count: expected a whole number in \[2, 900\], as an episode lasts 60 s at the most, got 1",
        ),
        ({"frame_count": 1000}, r"frame_count: expected a whole number in \[2, 900\], .*, got 1000"),
        ({"rate_hz": 0.0}, r"rate_hz: expected a number in \[0.0333, 1000\], got 0.0"),
        ({"width_px": 16}, "width_px: expected a whole number from 32 to 4096, got 16"),
        ({"height_px": -480}, "height_px: expected"),
        ({"crossers": -1}, r"crossers: expected a number in \[0, 30\], got -1"),
        ({"alike": -1}, "alike: expected"),
        ({"uniformed": -1}, "uniformed: expected"),
        ({"lamp_events": -2}, "lamp_events: expected"),
        ({"lamps_off_s": (3.0, 1.0)}, r"lamps_off_s: expected two numbers in ascending order in \[0, 600\], got"),
        ({"lamps_left_on": (0.5, 1.5)}, r"lamps_left_on: expected two numbers in ascending order in \[0, 1\]"),
        ({"cloud_s": (-1.0, 1.0)}, "cloud_s: expected"),
        ({"cloud_edge_s": 0.0}, r"cloud_edge_s: expected a number in \(0, 600\]"),
        ({"sky_behind_cloud": 0.0}, "sky_behind_cloud: expected"),
        ({"brightening_s": -1.0}, "brightening_s: expected"),
        (
            {"leg_m": (0.0, 0.0), "stays": 1.0},
            r"leg_m: expected two numbers in ascending order in \[0.7, 100\], got \(0.0, 0.0\)",
        ),
        ({"dropped_share": 1.5}, r"dropped_share: expected a number in \[0, 1\], got 1.5"),
        ({"dropped_share": float("nan")}, "dropped_share: expected"),
    ],
)
def test_presets_refuse_nonsense(nonsense, message):
    with pytest.raises(ValueError, match=message):
        replace(PRESETS["quick"], **nonsense)


def test_the_deleted_version_names_its_successor():
    with pytest.raises(ValueError, match="expected stereo-follow-v2, which took its place, got 'stereo-follow-v1'"):
        scenario("stereo-follow-v1")
    with pytest.raises(gymnasium.error.DeprecatedEnv, match="Please use `frameout/StereoFollow-v3` instead"):
        gymnasium.make("frameout/StereoFollow-v1")


def test_unknown_presets_and_negative_seeds_are_refused():
    with pytest.raises(ValueError, match=r"preset: expected one of .*paper-b3.*; got 'rush hour'"):
        scenario("stereo-follow").episode("rush hour", 0)
    with pytest.raises(ValueError, match="expected a whole number >= 0, got -1"):
        scenario("stereo-follow").episode("quick", -1)


@pytest.mark.heavy
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_as_many_right_pictures_are_lost_as_the_preset_says(share):
    plan = make_plan(replace(PRESETS["quick"], dropped_share=share, frame_count=200), 4, closed_loop=False)
    assert plan.dropped.mean() == pytest.approx(share, abs=0.1 if 0 < share < 1 else 0)
    assert plan.phase_rad.shape == (200, len(plan.looks))
    assert (np.diff(plan.phase_rad, axis=0) >= 0).all()
    assert len(plan.looks) == len(plan.crowd.walks)


def test_areas_hold_what_is_drawn_in_them():
    area = Area(1.0, 2.0, 3.0, 5.0)
    points_m = np.array([area.draw(np.random.default_rng(k)) for k in range(50)])
    assert area.holds(points_m).all()
    assert not area.holds(points_m + 10.0).any()
    assert area.shrunk(0.5) == Area(1.5, 2.5, 2.5, 4.5)
