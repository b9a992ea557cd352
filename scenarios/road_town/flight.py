"""The flight of the helicopter: its air, how it is steered, and the instruments that measure its pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.presets import ALTITUDE_RANGE_M, EgoErrors, RoadTown
from scenarios.road_town.swing_geometry import gust_angles_rad, pitched_forward, smooth_step
from sim.optics import look_down_pose
from sim.pose import rotation_by
from trackers.types import CameraCommand, CameraModel, Carrier, CommandAxis

MAXIMUM_SPEED_MPS = 25.0
MAXIMUM_CLIMB_MPS = 5.0
MAXIMUM_YAW_RATE_RAD_S = 1.0
HELICOPTER = Carrier(
    "helicopter",
    (
        CommandAxis("forward_mps", MAXIMUM_SPEED_MPS, 40.0),
        CommandAxis("right_mps", MAXIMUM_SPEED_MPS, 40.0),
        CommandAxis("climb_mps", MAXIMUM_CLIMB_MPS, 10.0),
        CommandAxis("yaw_rate_rad_s", MAXIMUM_YAW_RATE_RAD_S, 2.0),
    ),
    "down",
)
"""A stick moves from its centre to its stop within about half a second."""
_ATTITUDE_TIME_CONSTANT_S = 0.6
RESPONSE_TIME_S = 0.5
_WANDER_SHARE = 0.13
"""Standard deviation of ``AirState.wander_m``, as a share of half the picture's width on the ground."""


@dataclass(frozen=True, slots=True)
class Pulse:
    """One swing of the view away from the car and back.

    Attributes:
        start_frame, rise_frames, hold_frames, fall_frames: its timing.
        offset_m: (ahead, left) displacement of the aim on the ground at full swing, in the helicopter's frame.
        tilts: True for a gust that tilts the helicopter, False for a drift of the helicopter.
    """

    start_frame: int
    rise_frames: int
    hold_frames: int
    fall_frames: int
    offset_m: tuple[float, float]
    tilts: bool

    @property
    def end_frame(self) -> int:
        """The first frame on which the view is back."""
        return self.start_frame + self.rise_frames + self.hold_frames + self.fall_frames

    def share(self, frame_count: int) -> NDArray[np.float64]:
        """Return the share (T,) of the full swing on each frame, 0-1."""
        t = np.arange(frame_count) - self.start_frame
        back = t - self.rise_frames - self.hold_frames
        return smooth_step(t / self.rise_frames) - smooth_step(back / self.fall_frames)


@dataclass(frozen=True, eq=False)
class AirState:
    """The air of one episode, drawn before it starts and independent of the controller.

    Attributes:
        altitude_m: height at the start, to which a pilot keeps.
        attitude_rad: (T, 3) roll, pitch and yaw deviations in rough air.
        wander_m: (T, 2) slow deviation of a pilot's aim from the car.
        yaw_rad: heading at the start.
        mount_rad: angle by which the camera is pitched forward from straight down.
    """

    altitude_m: float
    attitude_rad: NDArray[np.float64]
    wander_m: NDArray[np.float64]
    yaw_rad: float
    mount_rad: float = 0.0


def draw_air(preset: RoadTown, car_heading_rad: float, rng: np.random.Generator) -> AirState:
    """Draw one episode's air: attitude noise is white noise through a second-order low pass.

    Args:
        car_heading_rad: at the start, about which the helicopter's is drawn.
    """
    frames, dt = preset.frame_count, 1.0 / preset.rate_hz
    deviation = np.deg2rad(preset.attitude_noise_deg) * np.array([1.0, 1.0, 1.5])
    altitude = rng.uniform(*preset.altitude_m)
    attitude = coloured_noise(rng, frames, 3, _ATTITUDE_TIME_CONSTANT_S / dt) * deviation
    half_width_m = altitude * np.tan(0.5 * np.deg2rad(preset.field_of_view_deg))
    wander = coloured_noise(rng, frames, 2, 2.5 / dt) * _WANDER_SHARE * half_width_m
    yaw = car_heading_rad + rng.normal(0, 0.3)
    low, high = preset.camera_pitch_deg
    mount = float(np.deg2rad(rng.uniform(low, high))) if high > 0.0 else 0.0
    return AirState(float(altitude), attitude, wander, float(yaw), mount)


def gust_attitude_rad(
    pulses: list[Pulse], altitude_m: float, frame_count: int, mount_rad: float = 0.0
) -> NDArray[np.float64]:
    """Return roll, pitch and yaw (T, 3) of the helicopter due to gusts, whose ``offset_m`` are those at ``altitude_m``.

    A camera pitched forward by ``mount_rad`` is swung aside by yaw instead of roll.
    """
    attitude = np.zeros((frame_count, 3))
    for pulse in pulses:
        if not pulse.tilts:
            continue
        share = pulse.share(frame_count)
        if mount_rad > 0.0:
            pitch, yaw = gust_angles_rad(pulse.offset_m, altitude_m, mount_rad)
            attitude[:, 1:] += share[:, None] * np.array([pitch, yaw])
        else:
            ahead, left = pulse.offset_m
            attitude[:, 0] += share * np.arctan2(left, altitude_m)
            attitude[:, 1] += share * np.arctan2(ahead, altitude_m)
    return attitude


class Helicopter:
    """A steered helicopter: it follows commands with a first-order response, while air and gusts tilt it."""

    def __init__(self, preset: RoadTown, air: AirState, pulses: list[Pulse], start_m: NDArray[np.float64]) -> None:
        self._dt_s = 1.0 / preset.rate_hz
        self._response = 1 - np.exp(-self._dt_s / RESPONSE_TIME_S)
        self._air = air
        self._attitude_rad = air.attitude_rad
        self.meet(pulses)
        self._position_m = np.array([*start_m, air.altitude_m])
        self._yaw_rad = air.yaw_rad
        self._velocity_mps = np.zeros(3)
        self._yaw_rate_rad_s = 0.0

    @property
    def position_m(self) -> NDArray[np.float64]:
        """Position (3,)."""
        return self._position_m

    @property
    def yaw_rad(self) -> float:
        """Heading, without that of the air."""
        return self._yaw_rad

    def meet(self, gusts: list[Pulse]) -> None:
        """Add gusts to the air of this flight."""
        air, frames = self._air, len(self._attitude_rad)
        self._attitude_rad = self._attitude_rad + gust_attitude_rad(gusts, air.altitude_m, frames, air.mount_rad)

    def fly_at(self, velocity_mps: NDArray[np.float64]) -> None:
        """Set the velocity (2,) over the ground at the start."""
        self._velocity_mps[:2] = velocity_mps

    def obey(self, command: CameraCommand, frame: int) -> None:
        """Advance by one frame under a command whose axes are those of the camera's measured heading.

        A pitched camera is swung aside by yaw: forward is then where the nose points on ``frame``, in the gust.
        """
        self.fly(command, float(self._attitude_rad[frame, 2]) if self._air.mount_rad > 0.0 else 0.0)

    def fly(self, command: CameraCommand, turned_rad: float = 0.0) -> None:
        """Advance by one frame.

        Args:
            turned_rad: angle from the helicopter's heading without that of the air to the command's axes.

        Raises:
            ValueError: if the command is not finite.
        """
        ahead, right, climb, yaw_rate = (
            float(v) for v in (command.forward_mps, command.right_mps, command.climb_mps, command.yaw_rate_rad_s)
        )
        if not all(math.isfinite(v) for v in (ahead, right, climb, yaw_rate)):
            raise ValueError(f"command: expected finite numbers, got {command}")
        c, s = math.cos(self._yaw_rad + turned_rad), math.sin(self._yaw_rad + turned_rad)
        wanted_mps = np.array([c * ahead + s * right, s * ahead - c * right, climb])
        horizontal = wanted_mps[:2]
        horizontal *= min(1.0, MAXIMUM_SPEED_MPS / max(math.sqrt(horizontal @ horizontal), 1e-9))
        wanted_mps[2] = min(max(climb, -MAXIMUM_CLIMB_MPS), MAXIMUM_CLIMB_MPS)
        self._velocity_mps += self._response * (wanted_mps - self._velocity_mps)
        yaw_rate = min(max(yaw_rate, -MAXIMUM_YAW_RATE_RAD_S), MAXIMUM_YAW_RATE_RAD_S)
        self._yaw_rate_rad_s += self._response * (yaw_rate - self._yaw_rate_rad_s)
        self._position_m = self._position_m + self._velocity_mps * self._dt_s
        self._position_m[2] = min(max(self._position_m[2], ALTITUDE_RANGE_M[0]), ALTITUDE_RANGE_M[1])
        self._yaw_rad += self._yaw_rate_rad_s * self._dt_s

    def pose(self, frame: int) -> NDArray[np.float64]:
        """Return T_world_camera (4, 4) of the given frame."""
        roll, pitch, yaw = self._attitude_rad[frame]
        level = look_down_pose(self._position_m, self._yaw_rad + yaw, pitch, roll)
        return pitched_forward(level, self._air.mount_rad)


def swing_out(camera: CameraModel, altitude_m: float, direction_rad: float, margin_m: float) -> tuple[float, float]:
    """Return the aim's displacement (ahead, left) that puts a centred car ``margin_m`` outside the border.

    ``direction_rad`` is that of the displacement, 0 = ahead, counter-clockwise.
    """
    half_ahead = 0.5 * camera.height_px / camera.focal_px * altitude_m
    half_left = 0.5 * camera.width_px / camera.focal_px * altitude_m
    c, s = np.cos(direction_rad), np.sin(direction_rad)
    # A tilted camera sees less ground towards the point below it: the near border of the picture comes closer.
    border = min(half_ahead / max(abs(c), 1e-6), half_left / max(abs(s), 1e-6))
    distance = border + margin_m
    return float(distance * c), float(distance * s)


def coloured_noise(
    rng: np.random.Generator, frames: int, channels: int, time_constant_frames: float
) -> NDArray[np.float64]:
    """Return noise (T, channels) of unit variance: white noise through two equal low passes."""
    warm_up = int(8 * time_constant_frames) + 1
    pole = np.exp(-1.0 / time_constant_frames)
    white = rng.normal(size=(frames + warm_up, channels))
    # It takes half a second to import, which only processes that plan a flight should cost.
    from scipy.signal import lfilter

    smooth = lfilter([1.0], np.convolve([1, -pole], [1, -pole]), white, axis=0)[warm_up:]
    # Variance of a second-order autoregression with the double pole p: (1 + p²) / (1 - p²)³.
    return smooth / np.sqrt((1 + pole**2) / (1 - pole**2) ** 3)


class Instruments:
    """Measures poses with white noise and a constant bias. The errors do not depend on the pose."""

    def __init__(self, errors: EgoErrors, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._position_bias_m = rng.normal(0.0, 1.0, 3) * errors.position_bias_m
        self._attitude_bias_deg = rng.normal(0.0, 1.0, 3) * errors.attitude_bias_deg

    def measure(self, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the measured T_world_camera (4, 4); the attitude error is a rotation about the camera's axes."""
        noise = self._rng.normal(0.0, 1.0, (2, 3))
        turn_deg = self._attitude_bias_deg + self._errors.attitude_noise_deg * noise[1]
        measured = T_world_camera.copy()
        measured[:3, :3] @= rotation_by(np.deg2rad(turn_deg))
        measured[:3, 3] += self._position_bias_m + self._errors.position_noise_m * noise[0]
        return measured
