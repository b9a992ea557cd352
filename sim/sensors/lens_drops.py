"""Raindrops on the window before a camera: discs in which the picture is blurred and bent.

A drop is a small lens: through it one sees a wide part of the scene, upside down and far out of focus. The camera is
focused on what is far, so that a drop's edge is as soft as the lens' opening is wide. Drops land by chance, stay for
seconds, and then run off; which ones follows from the generator alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, CameraMotion
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import Picture, SensorConfig, SensorSettings
from sim.sensors.motion_blur import blur_by_motion

_LANDING_PER_S = 0.45
"""Drops a second that land in the view in rain of 1 mm/h; with the square root of the rate."""
_STAY_S, _RUN_S = 5.0, 0.9
"""Mean time that a drop stays, and time in which it runs off."""
_RADIUS = (0.03, 0.1)
"""Range of radii, as shares of half the width of the view; drawn evenly in the logarithm."""
_SOFT = 0.5
"""Share of the radius over which the edge fades."""
_RUN = 1.6
"""Way of a drop that runs off, over half the view's height."""
_BLUR_CELL = 0.03
"""Side of the cells over which a drop averages, over half the view's width."""
_BENT = -0.35
"""Way in the picture behind a drop for each way within it."""
_STRENGTH = 0.88
"""Share of a drop's middle in which nothing of the sharp picture is left."""


@dataclass(frozen=True, eq=False)
class LensDrops:
    """The drops of an episode, K of them.

    Attributes:
        place: (K, 2) where each lands, in halves of the view's width to the right and down from its middle.
        radius: (K,) likewise. landed_s, gone_s: (K,) when it lands, and begins to run off.
        aside: (K,) way to the side for each way down, of one that runs off.
    """

    place: NDArray[np.float64]
    radius: NDArray[np.float64]
    landed_s: NDArray[np.float64]
    gone_s: NDArray[np.float64]
    aside: NDArray[np.float64]

    def at(self, time_s: float) -> NDArray[np.float64]:
        """Return x, y, half axes across and down (N, 4) of the drops that there are, in halves of the view's width."""
        run = np.clip((time_s - self.gone_s) / _RUN_S, 0.0, 1.0)
        there = (self.landed_s <= time_s) & (run < 1.0)
        run, place, radius = run[there], self.place[there], self.radius[there]
        down = _RUN * run**2
        # It grows longer and thinner on its way.
        across, length = radius * (1.0 - 0.45 * run), radius * (1.0 + 2.2 * run)
        return np.column_stack([place[:, 0] + self.aside[there] * down, place[:, 1] + down, across, length])


def draw_drops(rate_mm_h: float, duration_s: float, aspect: float, rng: np.random.Generator) -> LensDrops:
    """Draw the drops of an episode.

    Args:
        aspect: height of the view over its width.
    """
    per_s = _LANDING_PER_S * np.sqrt(rate_mm_h)
    # Those of before the first picture, too.
    count = int(rng.poisson(per_s * (duration_s + 2.0 * _STAY_S)))
    landed_s = rng.uniform(-2.0 * _STAY_S, duration_s, count)
    low, high = np.log(_RADIUS)
    return LensDrops(
        rng.uniform(-1.0, 1.0, (count, 2)) * (1.0, aspect),
        np.exp(rng.uniform(low, high, count)),
        landed_s,
        landed_s + rng.gamma(2.0, 0.5 * _STAY_S, count),
        rng.normal(0.0, 0.12, count),
    )


class WetCameraSensor(CameraSensor):
    """A camera sensor behind a window with drops."""

    def __init__(
        self, config: SensorConfig, rng: np.random.Generator, drops: LensDrops, camera: Camera, rate_hz: float
    ) -> None:
        """``camera``: whose view the drops refer to; a wider picture of the same lens shows them at the same places."""
        super().__init__(config, rng)
        self._drops, self._half_px, self._rate_hz = drops, 0.5 * camera.width_px, rate_hz

    def needs_whole(self, camera: Camera, settings: SensorSettings | None, motion: CameraMotion | None) -> bool:
        """Return True: drops bring light from one pixel to others."""
        return True

    def develop(
        self,
        radiance: NDArray[np.float32],
        camera: Camera,
        frame: int,
        settings: SensorSettings,
        motion: CameraMotion | None = None,
    ) -> Picture:
        """Take a picture through the window, see ``CameraSensor.develop``; the radiance is written to."""
        if motion is not None:
            radiance = blur_by_motion(radiance, motion.homography, settings.exposure_s / motion.interval_s)
        drops_px = self._half_px * self._drops.at(frame / self._rate_hz)
        drops_px[:, :2] += 0.5 * np.array([camera.width_px, camera.height_px])
        if len(drops_px):
            see_through(radiance, drops_px, max(round(_BLUR_CELL * self._half_px), 1))
        return super().develop(radiance, camera, frame, settings)


def see_through(radiance: NDArray[np.float32], drops_px: NDArray[np.float64], cell_px: int) -> None:
    """Change a radiance (H, 3, W) to what is seen through drops.

    Args:
        drops_px: (N, 4) x, y, half axes across and down.
        cell_px: side of the cells over which drops average.
    """
    height, width = radiance.shape[0], radiance.shape[2]
    rows, columns = max(height // cell_px, 1), max(width // cell_px, 1)
    area = cv2.INTER_AREA
    lines = cv2.resize(radiance.reshape(height, 3 * width), (3 * width, rows), interpolation=area)
    cells = cv2.resize(lines.reshape(3 * rows, width), (columns, 3 * rows), interpolation=area)
    _bend(np.ascontiguousarray(cells.reshape(rows, 3, columns)), drops_px, radiance)


@njit(cache=True)
def _bend(coarse: NDArray[np.float32], drops_px: NDArray[np.float64], seen: NDArray[np.float32]) -> None:
    """Mix the coarse picture (h, 3, w), upside down and wide, into the drops' discs."""
    height, width, rows, columns = seen.shape[0], seen.shape[2], coarse.shape[0], coarse.shape[2]
    for n in range(drops_px.shape[0]):
        x, y, across, down = drops_px[n]
        for row in range(max(int(y - down), 0), min(int(y + down) + 2, height)):
            v = (row + 0.5 - y) / down
            for column in range(max(int(x - across), 0), min(int(x + across) + 2, width)):
                u = (column + 0.5 - x) / across
                away = np.sqrt(u * u + v * v)
                if away >= 1.0:
                    continue
                edge = min((1.0 - away) / _SOFT, 1.0)
                weight = np.float32(_STRENGTH * edge * edge * (3.0 - 2.0 * edge))
                s = (x + _BENT * 4.0 * u * across) * columns / width - 0.5
                t = (y + _BENT * 4.0 * v * down) * rows / height - 0.5
                s, t = min(max(s, 0.0), columns - 1.001), min(max(t, 0.0), rows - 1.001)
                j, i = int(s), int(t)
                fs, ft = np.float32(s - j), np.float32(t - i)
                # Light from above gathers at a drop's lower edge.
                gleam = np.float32(1.0 + 0.12 * v)
                k, right = min(i + 1, rows - 1), min(j + 1, columns - 1)
                for channel in range(3):
                    upper = coarse[i, channel, j] + fs * (coarse[i, channel, right] - coarse[i, channel, j])
                    lower = coarse[k, channel, j] + fs * (coarse[k, channel, right] - coarse[k, channel, j])
                    bent = gleam * (upper + ft * (lower - upper))
                    seen[row, channel, column] += weight * (bent - seen[row, channel, column])
