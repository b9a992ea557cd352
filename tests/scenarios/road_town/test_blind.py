"""The helicopter's motion tells nothing of where a car is that its pilot cannot see."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.road_town import pilot
from scenarios.road_town.layout import Layout
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.pilot import IN, OUT, Drive, Pilot, Sighting, frame_out_spans, picture_states, plan_flight
from scenarios.road_town.plan import TARGET, make_plan
from scenarios.road_town.presets import PRESETS, RoadTown
from sim.rng import episode_seed
from tests.scenarios.road_town.blind_regression import Rows, gain_and_upper_end, joined, rows_of
from trackers.types import CameraModel

SET_PATHS = ("standard", "hard", "oblique", "paper-a3", "quick")
TELLING = ("standard", "hard")
"""Presets on which the regression finds out a pilot who is told where the lost car is; on others it has no power."""
FAR_AWAY_M, LONG_FRAMES = np.array([-5000.0, 3000.0]), 5
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])


DriveAndEvents = tuple[Drive, dict[str, list[int]]]
"""A car's drive, and the frames on which it starts to turn, and to leave the road."""


@dataclass(frozen=True, eq=False)
class Town:
    """A town and the drives of all its cars. The first one's has excursions."""

    seed: int
    layout: Layout
    drives: list[DriveAndEvents]


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
        off_road = [int(np.searchsorted(arc, each.leave_m + 4.0)) for each in plan.excursions if car == TARGET]
        drives.append((drive, {"turn": starts, "excursion": off_road}))
    return Town(plan.seed, plan.layout, drives)


def first(drive: Drive, frames: int) -> Drive:
    moving = ("position_m", "heading_rad", "speed_mps", "corners_m")
    return replace(drive, **{name: getattr(drive, name)[:frames] for name in moving})


def events_of(preset: RoadTown, drive: DriveAndEvents) -> dict[str, list[int]]:
    frames = range(1, preset.frame_count)
    return {name: [frame for frame in starts if frame in frames] for name, starts in drive[1].items()}


def camera_of(preset: RoadTown) -> CameraModel:
    angle_rad = float(np.deg2rad(preset.field_of_view_deg))
    return CameraModel.from_field_of_view(preset.width_px, preset.height_px, angle_rad)


@contextmanager
def told(drive: Drive) -> Iterator[None]:
    """Let the pilot know where the car is even while it is out of sight."""

    class Told(Pilot):
        def look(self, frame: int, seen: Sighting | None, view_is_back: bool) -> None:
            super().look(frame, drive.sighting(frame), view_is_back)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pilot, "Pilot", Told)
        yield


def flown(preset: RoadTown, towns: list[Town], cars: int, *, is_told: bool = False) -> Rows:
    """Return the rows of the flights after the first cars of some towns."""
    camera = camera_of(preset)
    parts: list[Rows] = []
    for each in towns:
        for car, drive_and_events in enumerate(each.drives[:cars]):
            driven = first(drive_and_events[0], preset.frame_count)
            events = events_of(preset, drive_and_events)
            with told(driven) if is_told else nullcontext():
                flight = plan_flight(preset, camera, each.layout, driven, events, False, each.seed + car)
            made = rows_of(len(parts), camera, flight.camera_poses, driven.position_m, driven.corners_m, preset.rate_hz)
            parts += [made] if len(made.episode) else []
    return joined(parts)


def unseen_span(camera: CameraModel, poses: NDArray[np.float64], layout: Layout, drive: Drive) -> tuple[int, int]:
    """Return the first frame on which the car is unseen and the first one on which it is seen again."""
    states, sight = picture_states(camera, poses, drive.corners_m), LineOfSight(layout)
    unseen = np.array(
        [
            state == OUT or sight.is_hidden(pose[:3, 3], place_m, float(heading_rad), drive.size_m)
            for state, pose, place_m, heading_rad in zip(
                states, poses, drive.position_m, drive.heading_rad, strict=True
            )
        ]
    )
    # Spans of a few frames behind a tree are over before a pilot would react.
    return next(span for span in frame_out_spans(np.where(unseen, OUT, IN)) if span[1] - span[0] >= LONG_FRAMES)


def elsewhere(drive: Drive, frame: int) -> Drive:
    """Return a drive that jumps far away and turns round on a frame."""
    place, heading, corners = drive.position_m.copy(), drive.heading_rad.copy(), drive.corners_m.copy()
    place[frame:] += FAR_AWAY_M
    corners[frame:, :, :2] += FAR_AWAY_M
    heading[frame:] += np.pi
    return replace(drive, position_m=place, heading_rad=heading, corners_m=corners)


def flights_with_and_without_the_car(preset: RoadTown, each: Town) -> tuple[NDArray[np.float64], ...]:
    """Return the poses from the car's loss to its return, and 30 frames on, of two flights.

    The car of the second flight is far away as soon as it is lost.
    """
    camera, driven = camera_of(preset), each.drives[0][0]
    flight = (preset, camera, each.layout)
    rest = (events_of(preset, each.drives[0]), False, each.seed)
    poses = plan_flight(*flight, driven, *rest).camera_poses
    start, end = unseen_span(camera, poses, each.layout, driven)
    others = plan_flight(*flight, elsewhere(driven, start), *rest).camera_poses
    return poses[: end + 1], others[: end + 1], poses[end + 1 : end + 30], others[end + 1 : end + 30]


@pytest.mark.heavy
@pytest.mark.parametrize("name", SET_PATHS)
def test_a_lost_car_does_not_move_the_camera_until_it_is_seen_again(name: str) -> None:
    for seed in (0, 1):
        lost, lost_elsewhere, back, back_elsewhere = flights_with_and_without_the_car(PRESETS[name], town(name, seed))
        np.testing.assert_array_equal(lost, lost_elsewhere)
        assert (back != back_elsewhere).any()


def test_a_told_pilot_follows_a_lost_car() -> None:
    each = town("standard", 0)
    camera, driven, preset = camera_of(PRESETS["standard"]), each.drives[0][0], PRESETS["standard"]
    rest = (events_of(preset, each.drives[0]), False, each.seed)
    with told(driven):
        poses = plan_flight(preset, camera, each.layout, driven, *rest).camera_poses
    start, end = unseen_span(camera, poses, each.layout, driven)
    other = elsewhere(driven, start)
    with told(other):
        others = plan_flight(preset, camera, each.layout, other, *rest).camera_poses
    assert (poses[:end] != others[:end]).any()


@pytest.mark.heavy
@pytest.mark.parametrize("name", TELLING)
def test_many_flights_of_a_pilot_who_is_told_would_be_found_out(name: str) -> None:
    rows = flown(PRESETS[name], [town(name, seed) for seed in range(40)], 5, is_told=True)
    gain, upper_end = gain_and_upper_end(rows, trees=20)
    print(f"{name}, told: {rows.episode.max() + 1} episodes, gain {gain:.3f}, upper end {upper_end:.3f}")
    assert gain > 0.1


@pytest.mark.heavy
@pytest.mark.parametrize("name", TELLING)
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
