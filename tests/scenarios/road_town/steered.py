"""Flights in closed loop without pictures, by controllers that know where the target truly is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import CommandLink, Link
from scenarios.road_town.flight import HELICOPTER, Helicopter, Instruments
from scenarios.road_town.plan import TARGET, Plan
from sim.optics import project
from sim.rng import generator
from trackers.protocols import Controller
from trackers.types import CameraCommand, EgoPose, Estimate, Observation


def share_in_view(plan: Plan, controller: Controller) -> float:
    """Return the share of the frames after the first one on which the target's centre is in the picture."""
    preset, camera = plan.preset, plan.camera
    assert preset.ego is not None
    helicopter = Helicopter(preset, plan.air, list(plan.pulses), plan.camera_poses[0, :2, 3])
    instruments = Instruments(preset.ego, generator(plan.seed, "instruments"))
    link = CommandLink(HELICOPTER, preset.rate_hz, Link(), generator(plan.seed, "link"))
    picture = np.zeros((camera.height_px, camera.width_px, 3), np.uint8)
    seen = []
    for frame in range(preset.frame_count):
        T_world_camera = helicopter.pose(frame)
        place_m = np.array([*plan.motion.position_m[frame, TARGET], 0.5 * plan.sizes_m[TARGET, 2]])
        position_px, depth_m = project(camera, T_world_camera, place_m)
        inside = (position_px >= 0.0).all() and (position_px <= [camera.width_px, camera.height_px]).all()
        seen.append(bool(depth_m > 0.0 and inside))
        ego = EgoPose(instruments.measure(T_world_camera))
        command = controller.command(
            Observation(picture, frame / preset.rate_hz, camera, ego=ego), _truth(position_px, float(depth_m), seen[-1])
        )
        helicopter.obey(link.send(command), frame)
    return float(np.mean(seen[1:]))


def shares_in_view(plans: list[Plan], create: Callable[[int], Controller]) -> NDArray[np.float64]:
    """Return the shares of plans, each with a fresh controller of its number."""
    return np.array([share_in_view(plan, create(number)) for number, plan in enumerate(plans)])


def _truth(position_px: NDArray[np.float64], depth_m: float, seen: bool) -> Estimate:
    if depth_m <= 0.0:
        return Estimate(np.full(2, np.nan), in_view_probability=0.0)
    return Estimate(position_px, in_view_probability=float(seen), covariance_px=1e-6 * np.eye(2))


class AtRandom:
    """Commands drawn anew on every frame, as by random actions of an env."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return a command from minus to plus the limit on every axis."""
        shares = self._rng.uniform(-1.0, 1.0, len(HELICOPTER.axes))
        return CameraCommand(
            **{axis.name: float(share * axis.limit) for axis, share in zip(HELICOPTER.axes, shares, strict=True)}
        )
