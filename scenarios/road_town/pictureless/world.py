"""Helicopters over towns, without pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.envs.pictureless.kernel_world import KernelWorld
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.road_town.pictureless.flight_kernel import FLIGHT_STATE
from scenarios.road_town.pictureless.road_kernel import ROAD_NOISE, Flights, begin_flights, fly_on
from scenarios.road_town.presets import RoadTown
from trackers.types import CameraModel


class RoadWorld(KernelWorld):
    """See ``KernelWorld``."""

    state_dtype = FLIGHT_STATE
    begin_kernel, move_kernel = staticmethod(begin_flights), staticmethod(fly_on)

    def __init__(
        self, preset: RoadTown, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> None:
        camera = CameraModel.from_field_of_view(
            preset.width_px, preset.height_px, float(np.deg2rad(preset.field_of_view_deg))
        )
        ego = preset.ego
        assert ego is not None
        degrees = np.deg2rad([ego.attitude_bias_deg, ego.attitude_noise_deg])
        noise = np.array([(ego.position_bias_m, ego.position_noise_m, degrees[0], degrees[1])], ROAD_NOISE)
        numbers, interval_s = camera_numbers(camera), 1.0 / preset.rate_hz
        super().__init__(Flights(**arrays, noise=noise, errors=errors, camera=numbers, interval_s=interval_s), link)
