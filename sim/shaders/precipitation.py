"""Flakes and drops that fall directly before the camera: those farther away are part of the air.

Drops have the sizes of Marshall and Palmer (1948), ``N(D) = 8000 exp(-4.1 R^-0.21 D)`` per m³ and mm; flakes are few
and large. What is near is out of focus: its picture is as wide as the lens' opening at that distance, and as long as
its way during the exposure, and it hides what lies behind by the share of that area which it really covers (Garg and
Nayar 2007). No fall lasts from one picture to the next: at 15 pictures a second and in the wind of flight each shows
others.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim.optics import Camera
from sim.rng import generator
from sim.shaders.specks import AHEAD_X, AHEAD_Y, BLUE, COLUMNS, COVER, LONG, RED, SHORT, X, Y

_NEAREST_M = 0.5
_FARTHEST_M = {"rain": 2.6, "snow": 4.0}
_FALL_MPS = {"rain": 6.5, "snow": 1.3}
_WIND_MPS = 7.0
"""Of flight and rotor, across the camera's view."""
_OPENING_M = 0.004
_EXPOSURE_S = 1.0 / 800.0
_FLAKES_M3 = 70.0
"""Of those larger than 2 mm in moderate snow."""
_DROPS_FROM_MM = 1.0
_MOST = 900


def count_per_m3(kind: Literal["rain", "snow"], rate_mm_h: float) -> float:
    """Return the number of drops above 1 mm, or of large flakes, in a cubic metre."""
    if rate_mm_h <= 0.0:
        return 0.0
    if kind == "snow":
        return _FLAKES_M3 * rate_mm_h
    slope = 4.1 * rate_mm_h**-0.21
    return float(8000.0 / slope * np.exp(-slope * _DROPS_FROM_MM))


def falling_specks(
    kind: Literal["rain", "snow"],
    rate_mm_h: float,
    seed: int,
    frame: int,
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    nit: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Return the specks of what falls before the camera in one picture.

    Args:
        rate_mm_h: of rain, or of molten snow. seed, frame: determine them.
        nit: (3,) luminance of what falls.
    """
    rng = generator(seed, f"{kind} of frame {frame}")
    far_m, half = _FARTHEST_M[kind], 0.55 * np.array([camera.width_px, camera.height_px])
    volume_m3 = 4.0 * half.prod() / camera.focal_px**2 * (far_m**3 - _NEAREST_M**3) / 3.0
    count = min(int(rng.poisson(count_per_m3(kind, rate_mm_h) * volume_m3)), _MOST)
    # Evenly over the volume of the view.
    away_m = np.cbrt(rng.uniform(_NEAREST_M**3, far_m**3, count))
    pixels = rng.uniform(-half, half, (count, 2))
    radius_m = (
        0.5e-3 * (_DROPS_FROM_MM + rng.exponential(0.4, count))
        if kind == "rain"
        else 1e-3 * rng.gamma(4.0, 0.45, count)
    )
    # Its way in the camera's frame: down, and with the wind of flight towards the picture's lower edge.
    down = -T_world_camera[2, :3]
    velocity = _FALL_MPS[kind] * down + _WIND_MPS * np.array([0.15, 1.0, 0.0])
    velocity = velocity + rng.normal(0.0, 0.12 * _WIND_MPS, (count, 3))
    across = (velocity[:, :2] - velocity[:, 2:] * pixels / camera.focal_px) / away_m[:, None]
    way_px = across * camera.focal_px * _EXPOSURE_S
    half_way_px = 0.5 * np.linalg.norm(way_px, axis=1)
    sharp_px, blur_px = camera.focal_px * radius_m / away_m, 0.5 * camera.focal_px * _OPENING_M / away_m
    width_px = np.maximum(np.hypot(sharp_px, blur_px), 0.7)
    table = np.zeros((count, COLUMNS), np.float32)
    table[:, [X, Y]] = pixels + 0.5 * np.array([camera.width_px, camera.height_px])
    table[:, [AHEAD_X, AHEAD_Y]] = way_px / np.maximum(2.0 * half_way_px, 1e-9)[:, None]
    table[:, LONG], table[:, SHORT] = width_px + half_way_px, width_px
    cover = np.clip(3.0 * sharp_px**2 / (width_px * (width_px + half_way_px)), 0.0, 1.0)
    table[:, COVER] = cover
    table[:, RED : BLUE + 1] = cover[:, None] * nit
    return table
