"""Meshes of a thermal world: closed and sound, and in every face the part that it is."""

from __future__ import annotations

import numpy as np
import pytest

from sim.meshes.boat import BOATS, BoatPart, boat
from sim.meshes.gull import gull
from sim.meshes.person import person_parts
from sim.meshes.person_parts import PersonLook
from sim.meshes.shed import Opening, ShedPart, shed
from sim.meshes.thermal_paint import (
    KELVIN_PER_LEVEL,
    NO_VARIATION,
    CarPart,
    PersonPart,
    blotches,
    scaled,
    thermal_car,
    thermal_person,
    varied,
)
from sim.meshes.vehicle import CARS, vehicle
from tests.sim.meshes.mesh_checks import require_closed, require_sound, texels


def rng_of(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


@pytest.mark.parametrize("model", BOATS)
def test_a_boat_is_closed_as_long_and_broad_as_asked_and_reaches_below_its_waterline(model: str) -> None:
    mesh = boat(model, 8.0, 2.8)
    require_sound(mesh)
    require_closed(mesh)
    assert mesh.size_m[0] == pytest.approx(8.0, abs=0.5)
    assert mesh.size_m[1] == pytest.approx(2.8, abs=1e-5)
    assert mesh.vertices_m[:, 2].min() < -0.3
    parts = texels(mesh)[:, 0]
    middle = mesh.vertices_m[mesh.faces].mean(axis=1)
    assert middle[parts == BoatPart.WET, 2].max() < 0.3
    assert BoatPart.DECK in parts
    # A fisher's stack and an outboard engine stand clear of the water.
    if model != "yacht":
        assert mesh.vertices_m[mesh.faces][parts == BoatPart.ENGINE][..., 2].max() > 0.4


@pytest.mark.parametrize("flies", [True, False])
def test_a_gull_is_closed_and_spreads_its_wings_only_to_fly(flies: bool) -> None:
    mesh = gull(flies)
    require_sound(mesh)
    require_closed(mesh)
    assert (mesh.size_m[1] > 1.2) == flies


def test_unknown_boats_and_impossible_sizes_are_named() -> None:
    with pytest.raises(ValueError, match=r"^model: expected one of fisher, launch, yacht, got ferry"):
        boat("ferry", 8.0, 3.0)
    with pytest.raises(ValueError, match=r"^length_m beam_m: expected lengths > 0 m, got"):
        boat("fisher", 8.0, 0.0)
    with pytest.raises(ValueError, match=r"^factors: expected three factors > 0, got"):
        scaled(gull(True), (1.0, 0.0, 1.0))
    with pytest.raises(ValueError, match=r"^part: expected 0 to 15, got 16"):
        varied(16, np.zeros((2, 2)))


@pytest.mark.parametrize("model", CARS)
def test_a_car_has_its_engine_ahead_tyres_at_the_bottom_and_its_roof_on_top(model: str) -> None:
    factors = (1.1, 0.9, 1.05)
    mesh = thermal_car(model, factors)
    require_sound(mesh)
    require_closed(mesh)
    np.testing.assert_allclose(mesh.size_m, vehicle(model, (0, 0, 0)).size_m * factors, rtol=1e-5)
    length, _, height = mesh.size_m
    parts, middle = texels(mesh)[:, 0], mesh.vertices_m[mesh.faces].mean(axis=1)
    assert set(parts) == set(CarPart)
    assert middle[parts == CarPart.BONNET, 0].min() > 0.2 * length
    assert middle[parts == CarPart.TYRE, 2].max() < 0.5 * height
    assert middle[parts == CarPart.ROOF, 2].min() > 0.8 * height
    # What touches the ground is a tyre, and nothing else is.
    touches = mesh.vertices_m[mesh.faces][..., 2].min(axis=1) < 0.05 * height
    assert set(parts[touches]) == {CarPart.TYRE}


def test_a_person_has_the_shape_of_the_visible_one_and_bare_skin_where_the_clothes_end() -> None:
    look = PersonLook(sleeves="short", legwear="shorts")
    bare, dressed = thermal_person(look, rng_of(1)), thermal_person(PersonLook(), rng_of(1))
    for name, mesh in person_parts(look, rng_of(1)).items():
        np.testing.assert_array_equal(bare[name].vertices_m, mesh.vertices_m)
        np.testing.assert_array_equal(bare[name].uv, mesh.uv)

    def main_part(mesh_by_name: dict, name: str) -> int:
        return int(np.bincount(texels(mesh_by_name[name])[:, 0]).argmax())

    assert main_part(bare, "left_forearm") == PersonPart.SKIN
    assert main_part(dressed, "left_forearm") == PersonPart.TOP
    assert main_part(bare, "right_shin") == PersonPart.SKIN
    assert main_part(dressed, "right_shin") == PersonPart.LEGS
    assert {PersonPart.SKIN, PersonPart.HAIR} <= set(texels(dressed["head"])[:, 0])
    assert main_part(dressed, "torso") == PersonPart.TOP
    assert main_part(dressed, "left_foot") == PersonPart.SHOES


def test_a_shed_shows_doors_and_windows_where_they_were_put_as_seen_from_the_sea() -> None:
    door, window = Opening(ShedPart.DOOR, 4.0, 1.5, 0.0, 2.2), Opening(ShedPart.GLASS, -5.0, 1.0, 1.2, 2.2)
    walls, roof = shed((20.0, 8.0, 4.0), 2.0, [door, window], rng_of(2))
    for mesh in (walls, roof):
        require_sound(mesh)
    picture = walls.texture.rgb[..., 0]
    rows, columns = picture.shape

    def part_at(y: float, z: float) -> int:
        # The front's left edge is at y = +10 as seen from -x.
        return int(picture[int(rows * (1.0 - z / 4.0)), int(columns * (10.0 - y) / 20.0)])

    assert part_at(4.0, 1.0) == ShedPart.DOOR
    assert part_at(-5.0, 1.7) == ShedPart.GLASS
    assert part_at(-5.0, 0.5) == part_at(4.0, 3.0) == part_at(0.0, 1.0) == ShedPart.WALL
    front = np.abs(walls.normals - (-1.0, 0.0, 0.0)).max(axis=1) < 1e-6
    left = walls.vertices_m[front][walls.uv[front, 0] == 0.0]
    assert (left[:, 1] == 10.0).all()
    assert (roof.normals[:, 2] > 0.5).sum() >= 8


def test_variation_is_kept_to_a_step_and_blotches_have_their_spread() -> None:
    variation_k = blotches((64, 96), ((8.0, 0.5),), rng_of(3))
    assert variation_k.std() == pytest.approx(0.5, rel=1e-6)
    green = varied(5, variation_k).rgb[..., 1].astype(int)
    np.testing.assert_allclose((green - NO_VARIATION) * KELVIN_PER_LEVEL, variation_k, atol=0.5 * KELVIN_PER_LEVEL)
    assert (varied(5, variation_k).rgb[..., 0] == 5).all()
