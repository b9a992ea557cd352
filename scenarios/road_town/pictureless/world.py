"""Helicopters over towns, without pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.road_town.pictureless.flight_kernel import FLIGHT_LIFE
from scenarios.road_town.pictureless.road_kernel import ROAD_NOISE, begin_flights, fly_on
from scenarios.road_town.presets import RoadTown
from sim.optics import PinholeCamera

_ARRAYS = ("target_m", "target_rad", "size_m", "attitude_rad", "start_m", "path_m", "yaw_rad", "onsets")


class RoadWorld:
    """See ``scenarios.scenario.World``."""

    life = FLIGHT_LIFE

    def __init__(
        self, preset: RoadTown, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        self.interval_s = 1.0 / preset.rate_hz
        self.camera = camera_numbers(
            PinholeCamera.from_field_of_view(
                preset.width_px, preset.height_px, float(np.deg2rad(preset.field_of_view_deg))
            )
        )
        ego = preset.ego
        assert ego is not None
        degrees = np.deg2rad([ego.attitude_bias_deg, ego.attitude_noise_deg])
        noise = np.array([(ego.position_bias_m, ego.position_noise_m, degrees[0], degrees[1])], ROAD_NOISE)
        bank = tuple(arrays[name] for name in _ARRAYS)
        self._fixed = (bank, noise, errors, self.camera, self.interval_s)
        self._link = link

    def begin(self, lives: Any, which: Any, episodes: Any, at_frame_outs: bool, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        begin_flights(lives, which, episodes, at_frame_outs, *self._fixed, sightings, rng)

    def move(self, lives: Any, wanted: Any, waiting: Any, sightings: Any, rng: Any) -> None:
        """See ``World``."""
        link = self._link
        fly_on(lives, wanted, link.limits, link.steps, waiting, link.noise, *self._fixed, sightings, rng)
