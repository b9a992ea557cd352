"""The helicopter's motion tells nothing of where a car is that its pilot cannot see; in edition 1 it tells much."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.road_town.flight_plan import plan_flight
from scenarios.road_town.layout import Layout
from scenarios.road_town.piloted_flight import Drive
from scenarios.road_town.plan import make_plan
from scenarios.road_town.presets import PRESETS, PRESETS_V1, RoadTown
from sim.optics import PinholeCamera
from sim.rng import episode_seed
from tests.scenarios.road_town.blind_regression import Rows, gain_and_upper_end, joined, rows_of

SET_PATHS = ("standard", "hard", "oblique", "paper-a3", "quick")
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])


@dataclass(frozen=True, eq=False)
class Town:
    """A town and the drives of all its cars, each with the frames on which it starts to turn."""

    seed: int
    layout: Layout
    drives: list[tuple[Drive, list[int]]]


@cache
def town(preset: str, seed: int) -> Town:
    plan = make_plan(PRESETS[preset], episode_seed(seed, "road-town-v2", 0), closed_loop=False)
    motion = plan.motion
    drives = []
    for car, route in enumerate(plan.routes):
        heading, arc = motion.heading_rad[:, car], motion.arc_m[:, car]
        c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
        local = CORNERS * plan.sizes_m[car]
        place = motion.position_m[:, car]
        corners = np.stack(
            [
                place[:, :1] + c * local[:, 0] - s * local[:, 1],
                place[:, 1:] + s * local[:, 0] + c * local[:, 1],
                np.broadcast_to(local[:, 2], (len(arc), 8)),
            ],
            axis=2,
        )
        drive = Drive(place, heading, motion.speed_mps[:, car], corners, plan.sizes_m[car])
        starts = [int(np.searchsorted(arc, passage.enter_m)) for passage in route.passages if passage.is_turn]
        drives.append((drive, starts))
    return Town(plan.seed, plan.layout, drives)


def first(drive: Drive, frames: int) -> Drive:
    moving = ("position_m", "heading_rad", "speed_mps", "corners_m")
    return replace(drive, **{name: getattr(drive, name)[:frames] for name in moving})


def flown(preset: RoadTown, towns: list[Town], cars: int) -> Rows:
    """Return the rows of the flights after the first cars of some towns."""
    camera = PinholeCamera.from_field_of_view(
        preset.width_px, preset.height_px, float(np.deg2rad(preset.field_of_view_deg))
    )
    parts: list[Rows] = []
    for each in towns:
        for car, (drive, turns) in enumerate(each.drives[:cars]):
            driven = first(drive, preset.frame_count)
            events = {"turn": [frame for frame in turns if 0 < frame < preset.frame_count], "excursion": []}
            flight = plan_flight(preset, camera, each.layout, driven, events, False, each.seed + car)
            made = rows_of(len(parts), camera, flight.camera_poses, driven.position_m, driven.corners_m, preset.rate_hz)
            parts += [made] if len(made.episode) else []
    return joined(parts)


def test_in_edition_1_the_flight_gives_the_car_away() -> None:
    rows = flown(PRESETS_V1["standard"], [town("standard", seed) for seed in (0, 1, 2)], 10)
    assert gain_and_upper_end(rows, trees=0)[0] > 0.1


@pytest.mark.parametrize("name", SET_PATHS)
def test_the_flight_does_not_give_the_car_away(name: str) -> None:
    rows = flown(PRESETS[name], [town("standard", seed) for seed in (0, 1)], 8)
    assert gain_and_upper_end(rows, trees=0)[0] <= 0.05


@pytest.mark.heavy
def test_in_edition_1_many_flights_give_the_car_away() -> None:
    rows = flown(PRESETS_V1["standard"], [town("standard", seed) for seed in range(30)], 5)
    gain, upper_end = gain_and_upper_end(rows, trees=20)
    print(f"standard of edition 1: {rows.episode.max() + 1} episodes, gain {gain:.3f}, upper end {upper_end:.3f}")
    assert gain > 0.2


@pytest.mark.heavy
@pytest.mark.parametrize("name", SET_PATHS)
def test_many_flights_do_not_give_the_car_away(name: str) -> None:
    rows = flown(PRESETS[name], [town(name, seed) for seed in range(40)], 5)
    gain, upper_end = gain_and_upper_end(rows, trees=20)
    print(f"{name}: {rows.episode.max() + 1} episodes, gain {gain:.3f}, upper end {upper_end:.3f}")
    assert gain <= 0.05
    assert upper_end <= 0.10


def places(rng: np.random.Generator) -> NDArray[np.float64]:
    return rng.normal(size=(400, 2))


def test_the_regressor_finds_what_the_camera_tells_and_nothing_in_noise() -> None:
    rng = np.random.default_rng(0)
    place_m, noise = places(rng), places(rng)
    episode = np.arange(400) // 5
    assert gain_and_upper_end(Rows(noise, place_m + 0.1 * places(rng), place_m, episode), trees=10)[0] > 0.5
    assert abs(gain_and_upper_end(Rows(noise, places(rng), place_m, episode), trees=10)[0]) < 0.05
