"""The pilot follows the car, knows nothing of it while it is out of sight, and the camera is swung out as scheduled."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.road_town.flight import AirState, Pulse, draw_air, gust_attitude_rad
from scenarios.road_town.layout import Building, Layout, RoadGraph
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.pilot import IN, OUT, Drive, Pilot, PilotErrors, fly_after, frame_out_spans, picture_states
from scenarios.road_town.presets import PRESETS, RoadTown
from scenarios.road_town.swing_geometry import gust_angles_rad, gust_out, pitched_forward
from sim.optics import intersect_plane, look_down_pose, project
from sim.rng import generator
from trackers.types import CameraModel

CAMERA = CameraModel.from_field_of_view(640, 480, np.deg2rad(50.0))
HIGHEST_RAY_RAD = math.radians(85.0)
CAR_M = np.array([4.4, 1.8, 1.5])
FRAMES = 240
OPEN_LAND = Layout(420.0, RoadGraph(np.empty((0, 2)), ()), (), (), ())


def straight_drive(position_m: NDArray[np.float64]) -> Drive:
    corners = np.array([[x, y, z] for x in (-2.2, 2.2) for y in (-0.9, 0.9) for z in (0.0, 1.5)])
    places = np.concatenate([position_m, np.zeros((len(position_m), 1))], axis=1)
    return Drive(position_m, np.zeros(FRAMES), np.full(FRAMES, 8.0), corners + places[:, None], CAR_M)


def flown(
    preset: RoadTown, drive: Drive, swings: list[Pulse], layout: Layout = OPEN_LAND
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the poses and the car's states in the picture."""
    air = draw_air(preset, float(drive.heading_rad[0]), generator(5, "air"))
    poses, _ = fly_after(preset, CAMERA, air, swings, drive, LineOfSight(layout), generator(5, "pilot"))
    return poses, picture_states(CAMERA, poses, drive.corners_m)


ALONG_M = np.column_stack([8.0 / 15.0 * np.arange(FRAMES), np.zeros(FRAMES)])
GUST = Pulse(60, 6, 50, 6, (0.0, 60.0), True)


@pytest.mark.parametrize("preset", ["standard", "oblique"])
def test_a_car_that_is_never_swung_out_stays_in_the_picture(preset: str) -> None:
    _, states = flown(PRESETS[preset], straight_drive(ALONG_M), [])
    assert (states == IN).mean() > 0.95
    assert not (states == OUT).any()


@pytest.mark.parametrize("swing", [GUST, Pulse(40, 40, 15, 40, (0.0, 45.0), False)])
def test_nothing_that_an_unseen_car_does_moves_the_helicopter(swing: Pulse) -> None:
    preset = PRESETS["standard"]
    poses, states = flown(preset, straight_drive(ALONG_M), [swing])
    start, end = frame_out_spans(states)[0]
    elsewhere = ALONG_M.copy()
    elsewhere[start + 1 :] += [-300.0, 200.0]
    others, other_states = flown(preset, straight_drive(elsewhere), [swing])
    np.testing.assert_array_equal(poses[: end + 1], others[: end + 1])
    assert (other_states[start:] == OUT).all()
    assert (poses[end + 20] != others[end + 20]).any()
    climbed_m = others[-1, 2, 3] - others[end, 2, 3]
    assert climbed_m > 3.0, "he searches from higher up"


def test_a_swing_waits_until_the_car_has_been_in_view_and_ends_by_its_own_clock() -> None:
    early = replace(GUST, start_frame=3)
    _, states = flown(PRESETS["standard"], straight_drive(ALONG_M), [early, replace(GUST, start_frame=20)])
    assert (states[:25] == IN).all()
    (first, back), (second, _) = frame_out_spans(states)
    assert 25 <= first <= 31
    assert abs(back - first - 53) <= 6
    assert (states[back:second] == IN).sum() >= 25


class BehindAWall:
    """Hides the car over a piece of its way along x."""

    def __init__(self, from_m: float, to_m: float) -> None:
        self._from_m, self._to_m = from_m, to_m

    def is_hidden(self, camera_m: object, place_m: NDArray[np.float64], heading_rad: float, size_m: object) -> bool:
        return self._from_m < place_m[0] < self._to_m


def test_no_swing_begins_while_the_car_is_hidden_or_soon_after() -> None:
    preset, drive = PRESETS["standard"], straight_drive(ALONG_M)
    air = draw_air(preset, float(drive.heading_rad[0]), generator(5, "air"))
    starts = []
    for wall in (BehindAWall(0.0, 0.0), BehindAWall(*ALONG_M[[55, 80], 0])):
        _, (begun,) = fly_after(preset, CAMERA, air, [GUST], drive, wall, generator(5, "pilot"))  # type: ignore[arg-type]
        starts.append(begun.start_frame)
    assert starts == [60, 80 + 24]


def test_a_pilot_without_errors_flies_evenly_from_the_first_frame_on() -> None:
    preset, nothing = PRESETS["standard"], np.zeros(FRAMES)
    air = AirState(60.0, np.zeros((FRAMES, 3)), np.zeros((FRAMES, 2)), 0.0)
    errors = PilotErrors(nothing + 0j, nothing, nothing, nothing, nothing, nothing)
    drive = straight_drive(ALONG_M)
    pilot = Pilot(preset, air, errors, drive.sighting(0), 8.0)
    for frame in range(20):
        pilot.look(frame, drive.sighting(frame), True)
        command = pilot.command(frame, np.array([*ALONG_M[frame], 60.0]), 0.0, 0j, 0j)
        assert command.forward_mps == pytest.approx(8.0, abs=1e-9)
        assert command.right_mps == pytest.approx(0.0, abs=1e-9)


def test_a_house_hides_the_car_behind_it_alone() -> None:
    house = Building((20.0, 0.0), (12.0, 9.0, 8.0), 0.3, "flat", (200, 200, 200), (90, 90, 90))
    sight = LineOfSight(replace(OPEN_LAND, buildings=(house,)))
    low, above = np.array([0.0, 0.0, 20.0]), np.array([30.0, 0.0, 60.0])
    assert sight.is_hidden(low, np.array([30.0, 0.0]), 0.0, CAR_M)
    assert not sight.is_hidden(above, np.array([30.0, 0.0]), 0.0, CAR_M)
    assert not sight.is_hidden(low, np.array([30.0, 22.0]), 0.0, CAR_M)
    assert not sight.is_hidden(low, np.array([6.0, 0.0]), 0.0, CAR_M)


@pytest.mark.parametrize("altitude_m", [50.0, 80.0])
@pytest.mark.parametrize("margin_m", [10.0, 24.0, 33.0])
@pytest.mark.parametrize("mount_rad", np.deg2rad([35.0, 42.0, 50.0]))
@pytest.mark.parametrize("direction_rad", np.linspace(-math.pi, math.pi, 9))
def test_a_gust_swings_a_camera_pitched_forward_off_the_car_below_the_horizon(
    mount_rad: float, direction_rad: float, margin_m: float, altitude_m: float
) -> None:
    offset_m = gust_out(CAMERA, altitude_m, mount_rad, direction_rad, margin_m)
    above_m = np.array([0.0, 0.0, altitude_m])
    level = look_down_pose(above_m, 0.0, 0.0, 0.0)
    middle_m = np.array([*intersect_plane(CAMERA, pitched_forward(level, mount_rad), CAMERA.centre_px, 0.0), 0.0])
    np.testing.assert_allclose(middle_m, [altitude_m * math.tan(mount_rad), 0.0, 0.0], atol=1e-6)
    pitch, yaw = gust_angles_rad(offset_m, altitude_m, mount_rad)
    assert abs(yaw) <= 0.5 * math.pi
    assert -mount_rad < pitch < 1e-9
    gust = gust_attitude_rad([Pulse(0, 1, 10, 1, offset_m, True)], altitude_m, 6, mount_rad)
    np.testing.assert_allclose(gust[5], [0.0, pitch, yaw])
    swung = pitched_forward(look_down_pose(above_m, yaw, pitch, 0.0), mount_rad)
    aim_m = intersect_plane(CAMERA, swung, CAMERA.centre_px, 0.0)
    np.testing.assert_allclose(aim_m, middle_m[:2] + offset_m, atol=1e-6)
    pixel, _ = project(CAMERA, swung, middle_m)
    assert (pixel < 0).any() or (pixel > [640, 480]).any()
    assert mount_rad + pitch + math.atan(240.0 / CAMERA.focal_px) < HIGHEST_RAY_RAD
