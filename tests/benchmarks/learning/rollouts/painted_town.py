"""An env whose pictures tell frame and seed by their colour, and controllers for it, good and bad."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.learning.rollouts.making import make
from benchmarks.learning.rollouts.request import Rollouts
from scenarios import catalog
from scenarios.scenario import Frame, Setup
from tests.fakes_scenario import CAMERA, FAKE_TOWN, FakeEpisode, UnhashedSeeds
from trackers.controllers.catalogue import register_controller
from trackers.registry import NoParameters
from trackers.types import CameraCommand, Estimate, Observation

ENV = "frameout/PaintedTown-v1"
MODULES = (__name__,)


def painted(frame: int, seed: int) -> NDArray[np.uint8]:
    """Return the picture of a frame: a gradient to the right, whose red tells the frame and whose blue the seed."""
    picture = np.zeros((CAMERA.height_px, CAMERA.width_px, 3), np.uint8)
    picture[..., 0], picture[..., 2] = 8 * (frame % 32), 20 * (seed % 10)
    picture[..., 1] = np.linspace(20, 200, CAMERA.width_px)
    return picture


@dataclass
class _Painted(FakeEpisode):
    seed: int = 0

    def step(self, command: CameraCommand | None = None) -> Frame:
        frame = super().step(command)
        picture = painted(frame.truth.frame, self.seed)
        return replace(frame, observation=replace(frame.observation, image_rgb=picture))


def _episode(setup: Setup) -> _Painted:
    return _Painted(setup.preset, setup.closed_loop, phase_s=0.01 * (setup.seed % 10), seed=setup.seed)


PAINTED_TOWN = UnhashedSeeds(
    id="painted-town-v1",
    summary="cars on circles",
    start="the car's box",
    stage=_episode,
    presets={"standard": FAKE_TOWN.presets["tiny"]},
    classes=FAKE_TOWN.classes,
    carrier=FAKE_TOWN.carrier,
    truth=FAKE_TOWN.truth,
)
catalog.register(catalog.Entry(PAINTED_TOWN.id, f"{__name__}:PAINTED_TOWN", ENV, "fake_still"))


class _Controller:
    Parameters = NoParameters

    def __init__(self, parameters: NoParameters) -> None:
        self._pictures = 0

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        self._pictures += 1
        return self.number(self._pictures)

    def number(self, pictures: int) -> CameraCommand:
        raise NotImplementedError


@register_controller("wild", role="external", carrier="helicopter", summary="beyond all limits, then within them")
class Wild(_Controller):
    def number(self, pictures: int) -> CameraCommand:
        far = 1000.0 if pictures < 5 else 3.0
        return CameraCommand(forward_mps=far, right_mps=-far, climb_mps=1.0, yaw_rate_rad_s=0.1 * pictures)


@register_controller("fails", role="external", carrier="helicopter", summary="divides by zero on picture 4")
class Fails(_Controller):
    def number(self, pictures: int) -> CameraCommand:
        return CameraCommand(forward_mps=1.0 / (4 - pictures))


@register_controller("infinite", role="external", carrier="helicopter", summary="wants to be infinitely fast")
class Infinite(_Controller):
    def number(self, pictures: int) -> CameraCommand:
        return CameraCommand(forward_mps=np.inf)


FRAMES = 12


def rollouts(**changes: object) -> Rollouts:
    """Return an order of two short episodes."""
    asked = {"seeds": (3, 5), "format": "parquet", "controller": "wild", "modules": MODULES}
    asked |= {"env_kwargs": {"changes": {"frame_count": FRAMES}}}
    return Rollouts(ENV, **(asked | changes))  # type: ignore[arg-type]


def made(out: Path, workers: int = 0, **changes: object) -> Path:
    """Make a set without a progress bar; return its folder."""
    make(rollouts(**changes), out, workers, lambda done, of: None)
    return out
