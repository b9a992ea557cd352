"""Light of lamps: G-buffer in, radiance out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import PinholeCamera, rays
from sim.render.compilation import announce_compilation
from sim.shaders.black_body import black_body_rgb
from sim.shaders.colour import srgb_to_linear

_LINEAR = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
_NEAREST_M = 0.05
"""A lamp is no point: nobody gets nearer to it than this."""


@dataclass(frozen=True, slots=True)
class Lamp:
    """A small lamp that shines alike in all directions.

    Attributes:
        position_m: (x, y, z), world frame.
        flux_lm: luminous flux, >= 0: ``flux / 4 pi`` candela to every side.
        temperature_k: colour temperature, see ``black_body_rgb``.
    """

    position_m: tuple[float, float, float]
    flux_lm: float
    temperature_k: float


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What is around a place and not drawn: a closed room that throws light back.

    Attributes:
        surface_m2: of its walls, floor and ceiling together.
        reflectance: mean share of light thrown back, in [0, 1).
    """

    surface_m2: float
    reflectance: float


class LampShader:
    """Lights G-buffers by lamps. Shadows are not drawn: for places where nothing stands between lamp and surface."""

    def __init__(self, lamps: Sequence[Lamp], surroundings: Surroundings) -> None:
        """Set the light.

        Raises:
            ValueError: for a negative flux or impossible surroundings.
        """
        self.relight(lamps)
        _check("surface_m2", surroundings.surface_m2 > 0, "a number > 0", surroundings.surface_m2)
        _check("reflectance", 0 <= surroundings.reflectance < 1, "a number in [0, 1)", surroundings.reflectance)
        self._surroundings = surroundings

    def relight(self, lamps: Sequence[Lamp]) -> None:
        """Set other lamps: dimmed, switched on or off.

        Raises:
            ValueError: for a negative flux.
        """
        for lamp in lamps:
            _check("flux_lm", lamp.flux_lm >= 0, "a number >= 0", lamp.flux_lm)
        self._positions_m = np.array([lamp.position_m for lamp in lamps]).reshape(-1, 3)
        colours = [lamp.flux_lm * black_body_rgb(lamp.temperature_k) for lamp in lamps]
        self._flux_lm = np.array(colours).reshape(-1, 3)

    @property
    def _indirect_lx(self) -> NDArray[np.float64]:
        """Illuminance (3,) by light thrown back, everywhere the same: ``flux rho / (A (1 - rho))`` (integrating sphere)."""
        room = self._surroundings
        return self._flux_lm.sum(axis=0) * room.reflectance / (room.surface_m2 * (1.0 - room.reflectance))

    def illuminance_lx(self, points_m: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what falls on surfaces at points (N, 3) with unit normals (N, 3): (N, 3) lux of R, G and B.

        ``E = sum over lamps of flux / (4 pi) cos / d²`` and what the surroundings throw back.
        """
        result = np.empty((len(points_m), 3))
        for k in range(3):
            result[:, k] = self._indirect_lx[k]
        for position_m, flux_lm in zip(self._positions_m, self._flux_lm, strict=True):
            towards = position_m - points_m
            squared = np.maximum((towards**2).sum(axis=1), _NEAREST_M**2)
            facing = np.maximum((towards * normals).sum(axis=1), 0.0) / np.sqrt(squared)
            result += (facing / squared)[:, None] * flux_lm / (4 * np.pi)
        return result

    def shade(
        self, gbuffer: GBuffer, camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at pixel centres.

        ``L = rho E / pi``; 0 where there is no surface.
        """
        announce_compilation(_shade)
        corner, right, down = (
            rays(camera, T_world_camera, np.array(pixel)) for pixel in ((0.5, 0.5), (1.5, 0.5), (0.5, 1.5))
        )
        radiance = np.empty((camera.height_px, 3, camera.width_px), np.float32)
        _shade(
            gbuffer.base_colour_rgb,
            gbuffer.depth_m,
            gbuffer.normal_world,
            np.stack([T_world_camera[:3, 3], corner, right - corner, down - corner]),
            self._positions_m,
            self._flux_lm,
            self._indirect_lx,
            radiance,
        )
        return radiance


@njit(cache=True)
def _shade(
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    normal: NDArray[np.float32],
    view: NDArray[np.float64],
    positions_m: NDArray[np.float64],
    flux_lm: NDArray[np.float64],
    indirect_lx: NDArray[np.float64],
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance (H, 3, W).

    Args:
        view: (4, 3) the camera's place; the ray of the upper left pixel at depth 1; its change to the next pixel to the
            right and below.
    """
    point, total = np.empty(3), np.empty(3)
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            depth = depth_m[row, column]
            if not depth < np.inf:
                radiance[row, :, column] = 0.0
                continue
            for k in range(3):
                point[k] = view[0, k] + depth * (view[1, k] + column * view[2, k] + row * view[3, k])
                total[k] = indirect_lx[k]
            for lamp in range(positions_m.shape[0]):
                squared, along = 0.0, 0.0
                for k in range(3):
                    towards = positions_m[lamp, k] - point[k]
                    squared += towards * towards
                    along += towards * normal[row, column, k]
                squared = max(squared, _NEAREST_M * _NEAREST_M)
                arriving = max(along, 0.0) / (4.0 * np.pi * squared * np.sqrt(squared))
                for k in range(3):
                    total[k] += flux_lm[lamp, k] * arriving
            for k in range(3):
                radiance[row, k, column] = _LINEAR[base_colour_rgb[row, column, k]] * total[k] / np.pi


def _check(name: str, good: bool, expected: str, got: object) -> None:
    if not good:
        raise ValueError(f"{name}: expected {expected}, got {got}")
