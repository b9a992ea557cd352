"""The set path: a pilot's flight after the car, frame by frame, without pictures."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import AirState, Helicopter, Pulse
from scenarios.road_town.frame_outs import IN, OUT, picture_states
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.pilot import Pilot, Sighting, draw_errors
from scenarios.road_town.presets import SETTLE_FRAMES, RoadTown
from scenarios.road_town.swings import begun_at
from trackers.types import CameraModel


@dataclass(frozen=True, eq=False)
class Drive:
    """Motion of the car that is followed, over T frames.

    Attributes:
        position_m: (T, 2). heading_rad, speed_mps: (T,). corners_m: (T, 8, 3) of its box. size_m: (3,).
    """

    position_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    corners_m: NDArray[np.float64]
    size_m: NDArray[np.float64]

    def sighting(self, frame: int) -> Sighting:
        """Return what there is to see of the car on a frame."""
        return Sighting(complex(*self.position_m[frame]), float(self.heading_rad[frame]))


class _Swings:
    """The scheduled swings: each begins when it is due and the car has long been seen, and ends by its own clock."""

    def __init__(self, scheduled: list[Pulse], frame_count: int) -> None:
        self._waiting, self._frame_count = list(scheduled), frame_count
        self.begun: list[Pulse] = []
        self._seen_frames = 0

    def start(self, frame: int, is_seen_whole: bool) -> Pulse | None:
        """Return the swing that begins on a frame, if any, given whether the car is in sight and whole in the picture.

        Nothing else of the car counts: the start of a swing shall not tell of a car that is hidden.
        """
        self._seen_frames = self._seen_frames + 1 if is_seen_whole else 0
        due = self._waiting and self._waiting[0].start_frame <= frame
        if not due or self._seen_frames < SETTLE_FRAMES or self.going_on(frame):
            return None
        swing = begun_at(self._waiting.pop(0), frame, self._frame_count)
        self.begun += [swing] if swing else []
        return swing

    def going_on(self, frame: int) -> bool:
        """Return whether a swing is going on."""
        return bool(self.begun) and frame < self.begun[-1].end_frame


def fly_after(
    preset: RoadTown,
    camera: CameraModel,
    air: AirState,
    scheduled: list[Pulse],
    drive: Drive,
    sight: LineOfSight,
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], list[Pulse]]:
    """Fly after a car; return T_world_camera (T, 4, 4) and the swings that took place.

    The pilot gets the car's place only on frames on which it is at least partly in the picture and in sight.
    """
    frames = len(drive.position_m)
    first = drive.sighting(0)
    pilot = Pilot(preset, air, draw_errors(frames, preset.rate_hz, rng), first, float(drive.speed_mps[0]))
    helicopter = Helicopter(preset, air, [], drive.position_m[0] + air.wander_m[0] - _standoff_m(air))
    helicopter.fly_at(drive.speed_mps[0] * np.array([np.cos(first.heading_rad), np.sin(first.heading_rad)]))
    swings, poses = _Swings(scheduled, frames), np.empty((frames, 4, 4))
    drift_m = drift_mps = np.zeros(frames, complex)
    for frame in range(frames):
        pose = poses[frame] = helicopter.pose(frame)
        state = int(picture_states(camera, pose[None], drive.corners_m[frame : frame + 1])[0])
        place_m, heading_rad = drive.position_m[frame], float(drive.heading_rad[frame])
        seen = state != OUT and not sight.is_hidden(pose[:3, 3], place_m, heading_rad, drive.size_m)
        begun = swings.start(frame, seen and state == IN)
        if begun is not None and begun.tilts:
            helicopter.meet([begun])
        elif begun is not None:
            drift_m = begun.share(frames) * complex(*begun.offset_m) * cmath.rect(1.0, helicopter.yaw_rad)
            drift_mps = np.gradient(drift_m) * preset.rate_hz
        pilot.look(frame, drive.sighting(frame) if seen else None, not swings.going_on(frame))
        place = helicopter.position_m, helicopter.yaw_rad
        helicopter.fly(pilot.command(frame, *place, drift_m[frame], drift_mps[frame]))
    return poses, swings.begun


def _standoff_m(air: AirState) -> NDArray[np.float64]:
    """Return how far (2,) the helicopter keeps from the car at the start, against its nose."""
    yaw = air.yaw_rad
    return air.altitude_m * np.tan(air.mount_rad) * np.array([np.cos(yaw), np.sin(yaw)])
