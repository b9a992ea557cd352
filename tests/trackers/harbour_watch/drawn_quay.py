"""A quay drawn in NumPy: land, a wall, water with waves, a moored boat on the tide, and boxes as intruders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.site import SiteView
from trackers.types import CameraModel, EgoPose, Observation, SiteSurvey

CAMERA = CameraModel(256, 192, 770.0, band="thermal")
_DOWN = np.arctan2(20.0, 100.0)
_C, _S = np.cos(_DOWN), np.sin(_DOWN)
T_WORLD_CAMERA = np.array([[0.0, -_S, _C, -100.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -_C, -_S, 20.0], [0.0, 0.0, 0.0, 1.0]])
VIEW = SiteView(CAMERA, T_WORLD_CAMERA)
COUNTS_PER_K = 40.0
NOISE_K, WAVE_K, PATTERN_K = 0.07, 0.3, 0.15
WALL_X_M = -10.0
SURVEY = SiteSurvey((WALL_X_M, 0.0), (-1.0, 0.0), -1.8, (90.0, 33.0, 6.0), -2.5)
STEP_S = 2.0


@dataclass(frozen=True)
class Intruder:
    """A box: middle of its base (3,), size (3,), contrast in kelvin."""

    base_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    contrast_k: float


class Quay:
    """Draws pictures of one quay."""

    def __init__(self, seed: int, *, noise_k: float = NOISE_K, wave_k: float = WAVE_K) -> None:
        self._rng = np.random.default_rng(seed)
        self._noise_k, self._wave_k = noise_k, wave_k
        h, w = CAMERA.height_px, CAMERA.width_px
        texture = [cv2.GaussianBlur(self._rng.normal(size=(h, w)), (0, 0), s) * s for s in (2.0, 2.0)]
        self._land_k, self._sunlit_k = texture
        self._pattern_k = self._rng.normal(0.0, PATTERN_K, (h, w))

    def picture(self, time_s: float, *, tide_m: float, sun: float, intruders: Sequence[Intruder] = ()) -> Observation:
        """Return what the camera sees; ``sun`` 0 to 1 warms the land unevenly."""
        h, w = CAMERA.height_px, CAMERA.width_px
        kelvin = 288.0 + self._land_k + sun * (4.0 + 2.0 * self._sunlit_k)
        edges, _ = VIEW.project(np.array([[WALL_X_M, 0.0, 0.0], [WALL_X_M, 0.0, -1.8 + tide_m]]))
        top, foot = np.round(edges[:, 1]).astype(int)
        kelvin[top:foot] = 287.0 + 2.0 * sun
        waves = cv2.GaussianBlur(self._rng.normal(size=(h, w)), (0, 0), 1.2) * 4.0
        kelvin[foot:] = 284.0 + self._wave_k * waves[foot:]
        self._draw(kelvin, Intruder((-16.0, 6.0, -1.8 + tide_m), (5.0, 2.0, 1.5), 5.0 + sun))
        for intruder in intruders:
            self._draw(kelvin, intruder)
        kelvin = cv2.GaussianBlur(kelvin, (0, 0), 0.6) + self._pattern_k + self._rng.normal(0.0, self._noise_k, (h, w))
        counts = np.clip((kelvin - 260.0) * COUNTS_PER_K + 2000.0, 0, 16383).round().astype(np.uint16)
        grey = np.clip((kelvin - 280.0) * 12.0, 0, 255).astype(np.uint8)
        image_rgb = np.broadcast_to(grey[..., None], (h, w, 3))
        return Observation(image_rgb, time_s, CAMERA, ego=EgoPose(T_WORLD_CAMERA), counts=counts)

    def background(self, n: int = 60) -> list[Observation]:
        """Return pictures of three days without intruders."""
        return [
            self.picture(-86400.0 * 3 + 4320.0 * k, tide_m=0.8 * np.sin(0.9 * k), sun=0.5 + 0.5 * np.sin(0.37 * k))
            for k in range(n)
        ]

    def later(self, k: int, intruders: Sequence[Intruder] = (), *, tide_m: float = 0.1) -> Observation:
        """Return frame k of an episode in which tide and sun move slowly."""
        return self.picture(STEP_S * k, tide_m=tide_m + 1e-4 * k, sun=0.6 + 2e-4 * k, intruders=intruders)

    @staticmethod
    def _draw(kelvin: NDArray[np.float64], body: Intruder) -> None:
        centre = np.add(body.base_m, (0.0, 0.0, 0.5 * body.size_m[2]))
        estimate = VIEW.estimate_of(centre, np.array(body.size_m), 0.0)
        assert estimate is not None
        assert estimate.box_xyxy is not None
        x0, y0, x1, y1 = np.clip(np.round(estimate.box_xyxy), 0, [CAMERA.width_px, CAMERA.height_px] * 2).astype(int)
        kelvin[y0:y1, x0:x1] += body.contrast_k
