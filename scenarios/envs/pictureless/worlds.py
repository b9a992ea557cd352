"""What differs from scenario to scenario without pictures: the carrier, its instruments, what air or walls do."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import Link
from scenarios.envs.pictureless.bank import EpisodeBank
from scenarios.envs.pictureless.road_kernel import ROAD_NOISE, begin_flights, fly_on
from scenarios.envs.pictureless.stereo_kernel import begin_drives, drive_on
from scenarios.stereo_follow.camera import camera
from sim.optics import PinholeCamera
from trackers.types import BODY_COMMANDS, Carrier, CommandAxis


class World(Protocol):
    """Moves lives (B,) of dtype ``LIFE`` on.

    Attributes:
        camera: focal length, half width, half height (3,), pixels.
        limits, steps: (4,) of commands: range and largest change a frame, 0 where the carrier does not obey.
        interval_s: between frames.
    """

    camera: NDArray[np.float64]
    limits: NDArray[np.float64]
    steps: NDArray[np.float64]
    interval_s: float

    def begin(
        self,
        lives: NDArray[np.void],
        which: NDArray[np.int64],
        episodes: NDArray[np.int64],
        at_frame_outs: bool,
        sightings: NDArray[np.void],
        rng: np.random.Generator,
    ) -> None:
        """Begin episodes (K,) of the bank in the lives ``which`` (K,); write their first sightings."""
        ...

    def move(
        self,
        lives: NDArray[np.void],
        wanted: NDArray[np.float64],
        waiting: NDArray[np.float64],
        sightings: NDArray[np.void],
        rng: np.random.Generator,
    ) -> None:
        """Move all on by a frame, by commands wanted (B, 4); ``waiting`` (B, D, 4) are those on their way."""
        ...


class RoadWorld:
    """Helicopters over towns."""

    def __init__(self, bank: EpisodeBank, carrier: Carrier, link: Link, errors: NDArray[np.void]) -> None:
        preset = bank.preset
        self.interval_s = 1.0 / preset.rate_hz
        self.limits, self.steps = command_limits(carrier, self.interval_s)
        self.camera = camera_numbers(
            PinholeCamera.from_field_of_view(
                preset.width_px, preset.height_px, float(np.deg2rad(preset.field_of_view_deg))
            )
        )
        ego = preset.ego
        degrees = np.deg2rad([ego.attitude_bias_deg, ego.attitude_noise_deg])
        noise = (ego.position_bias_m, ego.position_noise_m, degrees[0], degrees[1])
        self._noise = np.array([noise], ROAD_NOISE)
        names = ("target_m", "target_rad", "size_m", "attitude_rad", "start_m", "path_m", "yaw_rad", "onsets")
        self._bank = tuple(bank.arrays[name] for name in names)
        self._link_noise, self._errors = link.noise, errors

    def begin(self, lives: Any, which: Any, episodes: Any, at_frame_outs: bool, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        fixed = (self._bank, self._noise, self._errors, self.camera, self.interval_s)
        begin_flights(lives, which, episodes, at_frame_outs, *fixed, sightings, rng)

    def move(self, lives: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        link = (self.limits, self.steps, waiting, self._link_noise)
        fixed = (self._bank, self._noise, self._errors, self.camera, self.interval_s)
        told = (*link, *fixed, sightings, rng)
        fly_on(lives, wanted, *told)


class StereoWorld:
    """Robots in buildings."""

    def __init__(self, bank: EpisodeBank, carrier: Carrier, link: Link, errors: NDArray[np.void]) -> None:
        preset = bank.preset
        self.interval_s = 1.0 / preset.rate_hz
        self.limits, self.steps = command_limits(carrier, self.interval_s)
        self.camera = camera_numbers(camera(preset.width_px, preset.height_px))
        names = ("target_m", "target_rad", "size_m", "others_m", "free_m", "openings_m", "path_m", "yaw_rad", "onsets")
        self._bank = tuple(bank.arrays[name] for name in names)
        self._link_noise, self._errors = link.noise, errors

    def begin(self, lives: Any, which: Any, episodes: Any, at_frame_outs: bool, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        fixed = (self._bank, self._errors, self.camera, self.interval_s)
        begin_drives(lives, which, episodes, at_frame_outs, *fixed, sightings, rng)

    def move(self, lives: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        link = (self.limits, self.steps, waiting, self._link_noise)
        drive_on(lives, wanted, *link, self._bank, self._errors, self.camera, self.interval_s, sightings, rng)


def world_of(bank: EpisodeBank, carrier: Carrier, link: Link, errors: NDArray[np.void]) -> World:
    """Return the world of a bank's scenario."""
    return (RoadWorld if carrier.looks == "down" else StereoWorld)(bank, carrier, link, errors)


def camera_numbers(camera: PinholeCamera) -> NDArray[np.float64]:
    """Return focal length, half width, half height (3,), pixels."""
    return np.array([camera.focal_px, 0.5 * camera.width_px, 0.5 * camera.height_px])


def command_limits(carrier: Carrier, interval_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return range and largest change a frame (4,) each of all commands, 0 of those that the carrier does not obey."""
    axes: dict[str, CommandAxis] = {axis.name: axis for axis in carrier.axes}
    limits = [axes[name].limit if name in axes else 0.0 for name in BODY_COMMANDS]
    steps = [axes[name].slew_per_s * interval_s if name in axes else 0.0 for name in BODY_COMMANDS]
    return np.array(limits), np.array(steps)
