"""The flight of an episode: the pilot who follows the car, the set path that he flies, and its frame-outs."""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import (
    MAXIMUM_CLIMB_MPS,
    AirState,
    Helicopter,
    Pulse,
    coloured_noise,
    draw_air,
)
from scenarios.road_town.layout import Layout
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.presets import ALTITUDE_RANGE_M, SETTLE_FRAMES, RoadTown
from scenarios.road_town.swings import begun_at, draw_swings
from sim.rng import generator
from trackers.types import CameraCommand, CameraModel

IN, PARTIAL, OUT = 0, 1, 2


def picture_states(
    camera: CameraModel, poses: NDArray[np.float64], corners_world_m: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return IN, PARTIAL or OUT for the box around ``corners_world_m`` (T, K, 3) in each frame (T,)."""
    points_camera = np.einsum("tkj,tji->tki", corners_world_m - poses[:, None, :3, 3], poses[:, :3, :3])
    behind = (points_camera[..., 2] <= 1e-6).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = camera.focal_px * points_camera[..., :2] / points_camera[..., 2:] + camera.centre_px
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    size = (camera.width_px, camera.height_px)
    out = behind | (high <= 0).any(axis=1) | (low >= size).any(axis=1)
    whole = (low >= 0).all(axis=1) & (high <= size).all(axis=1)
    return np.where(out, OUT, np.where(whole, IN, PARTIAL))


def frame_out_spans(states: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return (first frame out, first frame after it that is not out) of every stretch of OUT."""
    out = np.concatenate([[False], states == OUT, [False]])
    edges = np.flatnonzero(out[1:] != out[:-1])
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


REACTION_S = 0.3
_SIGHTING_ERROR_M, _HEADING_ERROR_RAD, _ERROR_TIME_S = 0.7, 0.08, 0.6
"""Standard deviations of a seen place and heading, and the time for which the errors last."""
_SPEED_ERROR, _DIRECTION_ERROR_RAD = 0.15, 0.1
"""Standard deviations of the relative error in speed and of the error in direction, at each loss of sight."""
_MEMORY_S = 0.4
"""Time constant of the place and the velocity that are taken from what is seen."""
_FORGOTTEN_AFTER_S = 1.0
"""A car that comes back after this time is taken anew, not averaged with where it had been expected."""
_GAIN_PER_S = 0.9
_YAW_GAIN_PER_S, _YAW_RATE_RAD_S, _OBLIQUE_YAW_RATE_RAD_S = 0.5, 0.5, 0.25
_SLOWING_S, _SEARCH_SLOWING_S = 8.0, 2.5
"""Times in which the expected speed of a lost car falls by a factor e, before the search and in it."""
_PATIENCE_S = 0.6
"""Time without the car, with the view back, after which the search begins."""
_WIDENING_MPS, _WIDEST_M, _CIRCLING_MPS, _SEARCH_CLIMB_MPS = 6.0, 60.0, 14.0, 4.0
_CLIMB_GAIN_PER_S = 0.4


@dataclass(frozen=True, slots=True)
class Sighting:
    """Place and heading of the car as the pilot sees them."""

    place_m: complex
    heading_rad: float


@dataclass(frozen=True, eq=False)
class PilotErrors:
    """Random numbers of one flight, drawn before it. Each has one value per frame (T,).

    Attributes:
        place_m, heading_rad: errors of what is seen.
        speed_share, direction_rad: errors of the memory, if sight is lost on that frame.
        search_rad: direction in which a search begins on that frame, and ``search_side`` = +-1 its sense.
    """

    place_m: NDArray[np.complex128]
    heading_rad: NDArray[np.float64]
    speed_share: NDArray[np.float64]
    direction_rad: NDArray[np.float64]
    search_rad: NDArray[np.float64]
    search_side: NDArray[np.float64]


def draw_errors(frame_count: int, rate_hz: float, rng: np.random.Generator) -> PilotErrors:
    """Draw the errors of one flight."""
    slow = coloured_noise(rng, frame_count, 3, _ERROR_TIME_S * rate_hz)
    return PilotErrors(
        _SIGHTING_ERROR_M * (slow[:, :2] @ np.array([1.0, 1j])),
        _HEADING_ERROR_RAD * slow[:, 2],
        1.0 + _SPEED_ERROR * rng.normal(size=frame_count),
        _DIRECTION_ERROR_RAD * rng.normal(size=frame_count),
        rng.uniform(-np.pi, np.pi, frame_count),
        rng.choice([-1.0, 1.0], frame_count),
    )


class Pilot:
    """Follows the car while it is seen; then flies on by its extrapolated motion, and searches for it.

    After the car is lost, nothing depends on its true motion until it is seen again.
    """

    def __init__(self, preset: RoadTown, air: AirState, errors: PilotErrors, first: Sighting, speed_mps: float) -> None:
        """``first``: the car on the first frame. Before it, it has come straight ahead at ``speed_mps``."""
        self._dt_s = 1.0 / preset.rate_hz
        self._air, self._errors = air, errors
        self._aim_m = air.wander_m @ np.array([1.0, 1j])
        self._nose_rad = air.yaw_rad - first.heading_rad
        delay = round(REACTION_S * preset.rate_hz)
        self._velocity_mps = cmath.rect(speed_mps, first.heading_rad)
        step_m = self._velocity_mps * self._dt_s
        before = [Sighting(first.place_m - k * step_m, first.heading_rad) for k in range(delay + 1, 0, -1)]
        self._place_m = before[0].place_m
        self._late: deque[Sighting | None] = deque(before[1:])
        self._delay_s = delay * self._dt_s
        self._heading_rad = first.heading_rad
        self._unseen_s = self._missed_s = self._searched_s = 0.0
        self._circle = 0j

    def look(self, frame: int, seen: Sighting | None, view_is_back: bool) -> None:
        """Take notice of what was seen ``REACTION_S`` ago.

        Args:
            seen: the car on this frame, None where it is out of sight.
            view_is_back: no swing is going on.
        """
        self._late.append(seen and self._with_errors(frame, seen))
        known = self._late.popleft()
        self._place_m += self._velocity_mps * self._dt_s
        if known is not None:
            self._correct(known)
            return
        if self._unseen_s == 0.0:
            error = cmath.rect(self._errors.speed_share[frame], self._errors.direction_rad[frame])
            self._velocity_mps *= error
        self._unseen_s += self._dt_s
        self._missed_s = self._missed_s + self._dt_s if view_is_back else 0.0
        slowing_s = _SEARCH_SLOWING_S if self._searched_s > 0.0 else _SLOWING_S
        self._velocity_mps *= math.exp(-self._dt_s / slowing_s)
        if self._missed_s > _PATIENCE_S + self._delay_s:
            self._search(frame)

    def command(
        self, frame: int, position_m: NDArray[np.float64], yaw_rad: float, drift_m: complex, drift_mps: complex
    ) -> CameraCommand:
        """Return the command that brings the view to the car or to where it is expected.

        Args:
            position_m: (3,) of the helicopter. drift_m, drift_mps: where it is carried to, relative to its place over
                the car, and how fast.
        """
        nose = cmath.rect(1.0, yaw_rad)
        standoff_m = position_m[2] * math.tan(self._air.mount_rad)
        expected_m = self._place_m + self._velocity_mps * self._delay_s + self._circle
        wanted_m = expected_m + self._aim_m[frame] - standoff_m * nose + drift_m
        here_m = complex(position_m[0], position_m[1])
        over_ground = (self._velocity_mps + drift_mps + _GAIN_PER_S * (wanted_m - here_m)) / nose
        searching = self._searched_s > 0.0
        climb = _SEARCH_CLIMB_MPS if searching else _CLIMB_GAIN_PER_S * (self._air.altitude_m - position_m[2])
        if position_m[2] >= ALTITUDE_RANGE_M[1]:
            climb = min(climb, 0.0)
        return CameraCommand(
            over_ground.real,
            -over_ground.imag,
            min(max(climb, -MAXIMUM_CLIMB_MPS), MAXIMUM_CLIMB_MPS),
            self._yaw_rate_rad_s(yaw_rad),
        )

    def _with_errors(self, frame: int, seen: Sighting) -> Sighting:
        errors = self._errors
        return Sighting(seen.place_m + errors.place_m[frame], seen.heading_rad + errors.heading_rad[frame])

    def _correct(self, known: Sighting) -> None:
        """Correct the memory by what is seen: a filter with two equal time constants (alpha-beta filter)."""
        if self._unseen_s > _FORGOTTEN_AFTER_S:
            self._place_m = known.place_m
            self._velocity_mps = cmath.rect(abs(self._velocity_mps), known.heading_rad)
        kept = math.exp(-self._dt_s / _MEMORY_S)
        innovation_m = known.place_m - self._place_m
        self._place_m += (1.0 - kept**2) * innovation_m
        self._velocity_mps += (1.0 - kept) ** 2 / self._dt_s * innovation_m
        self._heading_rad = known.heading_rad
        self._unseen_s = self._missed_s = self._searched_s = 0.0
        self._circle = 0j

    def _search(self, frame: int) -> None:
        """Go round the expected place in a widening spiral."""
        if self._searched_s == 0.0:
            self._bearing_rad = float(self._errors.search_rad[frame])
            self._side = float(self._errors.search_side[frame])
        self._searched_s += self._dt_s
        radius_m = min(_WIDENING_MPS * self._searched_s, _WIDEST_M)
        self._bearing_rad += self._side * _CIRCLING_MPS * self._dt_s / max(radius_m, 10.0)
        self._circle = cmath.rect(radius_m, self._bearing_rad)

    def _yaw_rate_rad_s(self, yaw_rad: float) -> float:
        """Return the yaw rate that turns the nose with the car; none while it is out of sight."""
        if self._unseen_s > 0.0:
            return 0.0
        fastest = _OBLIQUE_YAW_RATE_RAD_S if self._air.mount_rad > 0.0 else _YAW_RATE_RAD_S
        left_rad = math.remainder(self._heading_rad + self._nose_rad - yaw_rad, 2 * math.pi)
        return min(max(_YAW_GAIN_PER_S * left_rad, -fastest), fastest)


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


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """Attributes are those of ``Plan``."""

    air: AirState
    pulses: list[Pulse]
    camera_poses: NDArray[np.float64]


def plan_flight(
    preset: RoadTown,
    camera: CameraModel,
    layout: Layout,
    drive: Drive,
    events: dict[str, list[int]],
    closed_loop: bool,
    seed: int,
) -> FlightPlan:
    """Draw air and swings, and fly the set path.

    A pilot flies the set path. In closed loop the swings are those scheduled, and the pilot's path only says where
    pictureless flights may begin.

    Args:
        events: frames at which the car starts a ``turn`` or an ``excursion``.
    """
    rng = generator(seed, "air")
    air = draw_air(preset, float(drive.heading_rad[0]), rng)
    swings = draw_swings(preset, camera, air, events, closed_loop, rng)
    poses, begun = fly_after(preset, camera, air, swings, drive, LineOfSight(layout), generator(seed, "pilot"))
    return FlightPlan(air, swings if closed_loop else begun, poses)
