"""A pilot who follows a car by eye and, where it is out of sight, flies by what had been seen.

Places and velocities on the ground are complex numbers, ``x + i y`` in the world frame, in metres and m/s.
"""

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
    coloured_noise,
)
from scenarios.road_town.presets import ALTITUDE_RANGE_M, RoadTown
from trackers.types import CameraCommand

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
    """What the pilot sees of the car: its place and heading."""

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
