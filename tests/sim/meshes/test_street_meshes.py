"""Houses of many forms, overpasses, things in gardens and people: sound shapes of the promised size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.meshes.facets import Facets
from sim.meshes.overpass import PARAPET_M, SURFACES, cover, deck, embankment, pier, stairs
from sim.meshes.pedestrian import HIP, cyclist, draw_look, pedestrian, pedestrian_poses, stride_rate_radps
from sim.meshes.street_props import KINDS, add_prop, props_texture
from sim.meshes.varied_house import FORMS, LEVEL, SLOPING, WINDOWS, HouseStyle, varied_house
from sim.pose import pose_on_ground
from tests.sim.meshes.mesh_checks import require_closed, require_sound, texels

seeds = st.integers(0, 10_000)


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(FORMS), st.sampled_from(WINDOWS), st.sampled_from([(14.0, 9.0, 4.0), (9.0, 16.0, 7.5)]), seeds)
def test_a_house_of_any_form_is_closed_and_stands_on_its_ground(form, windows, size_m, seed) -> None:
    roofing = (LEVEL if form in ("flat", "stepped") else SLOPING)[seed % 3]
    mesh = varied_house(size_m, HouseStyle(form, roofing, windows, seed), (214, 204, 186))
    require_sound(mesh)
    require_closed(mesh)
    assert len(mesh.faces) <= 450
    low, high = mesh.bounds_m
    assert low[2] == pytest.approx(0.0, abs=1e-6)
    # Balconies hang over by 1.25 m, roofs by 0.4 m.
    assert (np.maximum(-low[:2], high[:2]) <= 0.5 * np.array(size_m[:2]) + 1.3).all()
    assert size_m[2] < high[2] < size_m[2] + 7.0


def test_a_house_is_the_same_for_the_same_style() -> None:
    style = HouseStyle("wing", "tiles", "tall", 7)
    first, second = (varied_house((12.0, 9.0, 4.0), style, (200, 200, 200)) for _ in range(2))
    np.testing.assert_array_equal(first.vertices_m, second.vertices_m)
    np.testing.assert_array_equal(first.texture.rgb, second.texture.rgb)


@pytest.mark.parametrize("bad", [{"form": "dome"}, {"roofing": "gold"}, {"windows": "none"}])
def test_an_unknown_style_is_refused(bad: dict[str, str]) -> None:
    with pytest.raises(ValueError, match=next(iter(bad))):
        HouseStyle(**{"form": "flat", "roofing": "metal", "windows": "single", "seed": 0} | bad)


@pytest.mark.parametrize("surface", SURFACES)
def test_decks_and_banks_leave_the_height_under_them_free(surface) -> None:
    span = deck(surface, 24.0, 9.0, 5.0, 6.0)
    require_sound(span)
    np.testing.assert_allclose(span.bounds_m, [(-12.0, -4.5, 5.0), (12.0, 4.5, 6.0 + PARAPET_M)])
    bank = embankment(surface, 60.0, 9.0, 6.0, 0.2)
    require_sound(bank)
    assert bank.bounds_m[1] == pytest.approx((60.0, 4.5 + 1.4 * 6.0, 6.0))


def test_a_cover_is_open_along_the_street() -> None:
    made = cover(30.0, 12.0, 5.0, 5.9, 6.5)
    require_sound(made)
    corners = made.vertices_m[made.faces].astype(float)
    # Over the street's middle there are only the ceiling and the grass.
    over = (np.abs(corners[..., 0]).min(axis=1) < 5.0) & (corners[..., 2].min(axis=1) < 4.9)
    assert not over.any()
    require_sound(pier(9.0, 5.0))
    require_sound(stairs(5.5, 9.0, 2.0))


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(sorted(KINDS)), seeds, st.floats(-3.0, 3.0))
def test_a_thing_stands_on_the_ground_that_it_takes(kind: str, variant: int, yaw_rad: float) -> None:
    size = {"hedge": (4.0, 0.8, 1.5), "fence": (4.0, 0.14, 1.1), "bin": (1.4, 0.7, 1.05), "sign": (0.1, 0.7, 2.6)}
    size_m = size.get(kind, (1.5, 1.5, 1.5))
    facets = Facets()
    add_prop(facets, kind, size_m, (10.0, -5.0), yaw_rad, variant)
    mesh = facets.mesh(props_texture())
    require_sound(mesh)
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    local = (mesh.vertices_m[:, :2] - (10.0, -5.0)) @ np.array([[c, -s], [s, c]])
    assert (np.abs(local) <= 0.5 * np.array(size_m[:2]) * 1.35 + 0.1).all()
    assert mesh.vertices_m[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert mesh.vertices_m[:, 2].max() <= 1.4 * size_m[2]


@settings(max_examples=15, deadline=None)
@given(seeds, st.floats(0.0, 6.3), st.floats(0.0, 2.0))
def test_a_walking_person_stands_on_the_ground_on_two_legs_of_one_length(seed, phase_rad, speed_mps) -> None:
    look = draw_look(np.random.Generator(np.random.PCG64(seed)))
    parts = pedestrian(look)
    for part in parts:
        require_sound(part)
        require_closed(part)
    T_world = pose_on_ground(3.0, -2.0, 0.7)
    one = np.array([look.stature_m]), T_world[None], np.array([phase_rad]), np.array([speed_mps])
    poses = pedestrian_poses(*one)[0]
    points = [part.vertices_m @ T[:3, :3].T + T[:3, 3] for part, T in zip(parts, poses, strict=True)]
    assert abs(min(each[:, 2].min() for each in points)) < 0.1
    assert np.concatenate(points)[:, 2].max() == pytest.approx(look.stature_m, abs=0.25)
    hips = poses[1:, :3, 3]
    np.testing.assert_allclose(hips[0], hips[1])
    assert 0.8 * HIP * look.stature_m < hips[0, 2] <= HIP * look.stature_m + 1e-9
    assert (stride_rate_radps(look, speed_mps) > 0) == (speed_mps > 0)


def test_a_cyclist_is_as_long_as_a_bicycle_and_wears_colours() -> None:
    mesh = cyclist(draw_look(np.random.Generator(np.random.PCG64(2))))
    require_sound(mesh)
    assert mesh.size_m == pytest.approx((1.76, 0.55, 1.85), abs=0.25)
    assert len({tuple(colour) for colour in texels(mesh).tolist()}) >= 5
