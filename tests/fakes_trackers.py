"""Trackers for the cars on circles of ``tests.fakes_scenario``, good and bad; importing it registers them."""

from __future__ import annotations

import os
import sys
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.optics import project
from tests import fakes_scenario
from tests.fakes_scenario import CAMERA, HEIGHT_M, RADIUS_M, SIZE_M
from trackers.registry import register
from trackers.types import Estimate, Observation


@dataclass(frozen=True)
class NoParameters:
    """Nothing to set."""


class _Fake:
    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._rng, self._frame = rng, 0

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self._box = box_xyxy
        self._centre = 0.5 * (box_xyxy[:2] + box_xyxy[2:])
        # The phase of the circle, read off the first box.
        camera_m = observation.ego.T_world_camera[:3, 3] if observation.ego else np.zeros(3)
        scale = (HEIGHT_M - 0.5 * SIZE_M[2]) / CAMERA.focal_px
        x, y = (self._centre - CAMERA.centre_px) * scale
        place = camera_m[:2] + np.array([-y, -x])
        self._phase = float(np.arctan2(place[1], place[0]))

    def update(self, observation: Observation) -> Estimate:
        self._frame += 1
        return self.misbehave(observation)

    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(self._centre, self._box)


@register("fake_knowing", role="ours", summary="knows the circle")
class Knowing(_Fake):
    """Is right but for noise, inside the picture and outside, and gives the noise as its posterior."""

    noise_m = 0.5

    def misbehave(self, observation: Observation) -> Estimate:
        # Asked anew: a test turns the cars the other way.
        angle = fakes_scenario.TURN_RAD_S * observation.time_s + self._phase
        middle = RADIUS_M * np.array([np.cos(angle), np.sin(angle)]) + self._rng.normal(0, self.noise_m, 2)
        points = np.vstack([middle, middle + self._rng.normal(0, self.noise_m, (200, 2))])
        height = np.full((201, 1), 0.5 * SIZE_M[2])
        assert observation.ego is not None
        pixels, _ = project(CAMERA, observation.ego.T_world_camera, np.hstack([points, height]))
        inside = bool(((pixels[0] >= 0) & (pixels[0] < [CAMERA.width_px, CAMERA.height_px])).all())
        half = 0.5 * (self._box[2:] - self._box[:2])
        box = np.concatenate([pixels[0] - half, pixels[0] + half])
        return Estimate(pixels[0], box, in_view_probability=float(inside), particles_px=pixels[1:])


@register("fake_still", role="baseline", summary="stays where the car was first")
class Still(_Fake):
    """The base behaviour."""


@register("fake_raises", role="baseline", summary="raises on frame 20")
class Raises(_Fake):
    """Has a bug."""

    def misbehave(self, observation: Observation) -> Estimate:
        if self._frame == 20:
            raise RuntimeError("a bug\nwith two lines")
        return Estimate(self._centre, self._box)


@register("fake_silent", role="baseline", summary="says nothing from frame 20 on")
class Silent(_Fake):
    """Answers NaN."""

    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(np.full(2, np.nan) if self._frame >= 20 else self._centre)


@register("fake_half_nan", role="baseline", summary="answers half a NaN on frame 20")
class HalfNan(_Fake):
    """Answers a position that is neither one nor none."""

    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(np.array([np.nan, 3.0]) if self._frame == 20 else self._centre)


@register("fake_wrong_shape", role="baseline", summary="answers three numbers on frame 20")
class WrongShape(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(np.zeros(3) if self._frame == 20 else self._centre)


@register("fake_slow", role="baseline", summary="sleeps on frame 20")
class Slow(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        if self._frame == 20:
            time.sleep(30.0)
        return Estimate(self._centre)


@register("fake_kills", role="baseline", summary="ends its process on frame 20")
class Kills(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        if self._frame == 20:
            os._exit(3)
        return Estimate(self._centre)


@register("fake_exits", role="baseline", summary="exits on frame 20")
class Exits(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        if self._frame == 20:
            sys.exit("bye")
        return Estimate(self._centre)


@register("fake_spoils", role="baseline", summary="paints on its picture on frame 20")
class Spoils(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        if self._frame == 20:
            observation.image_rgb[:] = 255
        return Estimate(self._centre)


@register("fake_prints", role="baseline", summary="prints on each frame")
class Prints(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        print("frame", self._frame, flush=True)
        return super().misbehave(observation)


@register("fake_sees", role="baseline", summary="where it was first, or far off if its picture is not black")
class Sees(_Fake):
    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(self._centre + float(observation.image_rgb.max()), self._box)
