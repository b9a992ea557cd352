"""Shader of lamps and bright areas, from G-buffer to radiance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import PinholeCamera, rays
from sim.render.compilation import announce_compilation
from sim.shaders.colour import black_body_rgb, srgb_to_linear

_LINEAR = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
_NEAREST_M = 0.05
"""Least distance to a lamp, which has a size."""
_PATCH_M = 0.6
"""Longest side of the patches of a bright area."""


@dataclass(frozen=True, slots=True)
class Lamp:
    """A small lamp of equal intensity in all directions.

    Attributes:
        position_m: (x, y, z), world frame.
        flux_lm: luminous flux, >= 0: ``flux / 4 pi`` candela in every direction.
        temperature_k: colour temperature, see ``black_body_rgb``.
    """

    position_m: tuple[float, float, float]
    flux_lm: float
    temperature_k: float


@dataclass(frozen=True, slots=True)
class BrightArea:
    """A window, an open door or a ceiling light: a rectangle of equal luminance in all directions before it.

    Attributes:
        instance_id: of its body, which is drawn with the luminance whatever its base colour.
        corner_m, side_a_m, side_b_m: one corner and two sides (3,), world frame; it faces ``side_a x side_b``.
        luminance_nit: >= 0.
        temperature_k: colour temperature, see ``black_body_rgb``.
    """

    instance_id: int
    corner_m: NDArray[np.float64]
    side_a_m: NDArray[np.float64]
    side_b_m: NDArray[np.float64]
    luminance_nit: float
    temperature_k: float


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Surroundings that are not drawn: a closed room that reflects light.

    Attributes:
        surface_m2: of its walls, floor and ceiling together.
        reflectance: mean share of light reflected, in [0, 1).
    """

    surface_m2: float
    reflectance: float


class Sources(NamedTuple):
    """Small sources as arrays for kernels.

    Attributes:
        positions_m: (N, 3).
        facing: (N, 3) unit vectors of patches, which shine with the cosine; 0 = alike in all directions.
        intensity_cd: (N, 3) of R, G and B, straight ahead.
        spread_m2: (N,) area / pi of patches, 0 of lamps.
        flux_lm: (3,) of all.
    """

    positions_m: NDArray[np.float64]
    facing: NDArray[np.float64]
    intensity_cd: NDArray[np.float64]
    spread_m2: NDArray[np.float64]
    flux_lm: NDArray[np.float64]


class LampShader:
    """Lights G-buffers by lamps and bright areas, without shadows."""

    def __init__(self, lamps: Sequence[Lamp], surroundings: Surroundings, areas: Sequence[BrightArea] = ()) -> None:
        """Set the light.

        Raises:
            ValueError: for a negative flux or luminance, an impossible temperature, an area without size, or impossible
                surroundings.
        """
        for lamp in lamps:
            check("flux_lm", lamp.flux_lm >= 0, "a number >= 0", lamp.flux_lm)
        for area in areas:
            check("luminance_nit", area.luminance_nit >= 0, "a number >= 0", area.luminance_nit)
        check("surface_m2", surroundings.surface_m2 > 0, "a number > 0", surroundings.surface_m2)
        check("reflectance", 0 <= surroundings.reflectance < 1, "a number in [0, 1)", surroundings.reflectance)
        self._sources = small_sources(lamps, areas)
        self._indirect_lx = (
            self._sources.flux_lm
            * surroundings.reflectance
            / (surroundings.surface_m2 * (1 - surroundings.reflectance))
        )
        # One row for each body up to the last one that shines, -1 where it does not.
        self._own_nit = np.full((max((area.instance_id for area in areas), default=-1) + 1, 3), -1.0)
        for area in areas:
            self._own_nit[area.instance_id] = area.luminance_nit * black_body_rgb(area.temperature_k)

    def illuminance_lx(self, points_m: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the illuminance (N, 3), lux of R, G and B, of surfaces at points (N, 3) with unit normals (N, 3).

        ``E = sum of I cos / d²`` over lamps, ``I = flux / (4 pi)``; over patches of area A and luminance L ``sum of
        L A cos' cos / (d² + cos'^4 A / pi)``: exact on the axis of a patch, elsewhere within 4 % from the length of its
        side on, and nearer up to a third too low beside its edge. To this the surroundings add a uniform reflection, as
        in an integrating sphere: ``flux rho / (surface (1 - rho))``.
        """
        result = np.empty((len(points_m), 3))
        _illuminate(points_m.astype(float), normals.astype(float), self._sources, self._indirect_lx, result)
        return result

    def shade(
        self, gbuffer: GBuffer, camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at pixel centres.

        ``L = rho E / pi``; 0 without a surface; bright areas have their own.
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
            gbuffer.instance_id,
            np.stack([T_world_camera[:3, 3], corner, right - corner, down - corner]),
            self._sources,
            self._indirect_lx,
            self._own_nit,
            radiance,
        )
        return radiance


def small_sources(lamps: Sequence[Lamp], areas: Sequence[BrightArea]) -> Sources:
    """Return lamps and, cut into patches, bright areas."""
    nowhere = np.zeros(3)
    small = [
        (lamp.position_m, nowhere, lamp.flux_lm / (4 * np.pi) * black_body_rgb(lamp.temperature_k)) for lamp in lamps
    ]
    spread_m2 = [0.0] * len(lamps)
    flux_lm = sum((lamp.flux_lm * black_body_rgb(lamp.temperature_k) for lamp in lamps), start=nowhere)
    for area in areas:
        across = np.cross(area.side_a_m, area.side_b_m)
        size_m2 = float(np.linalg.norm(across))
        check("side_a_m, side_b_m", size_m2 > 0, "sides of a rectangle", (area.side_a_m, area.side_b_m))
        nit = area.luminance_nit * black_body_rgb(area.temperature_k)
        flux_lm = flux_lm + np.pi * size_m2 * nit
        count_a, count_b = (
            int(np.ceil(np.linalg.norm(side) / _PATCH_M - 1e-9)) for side in (area.side_a_m, area.side_b_m)
        )
        for a in (np.arange(count_a) + 0.5) / count_a:
            for b in (np.arange(count_b) + 0.5) / count_b:
                middle_m = area.corner_m + a * area.side_a_m + b * area.side_b_m
                small.append((middle_m, across / size_m2, nit * size_m2 / (count_a * count_b)))
        spread_m2 += [size_m2 / (count_a * count_b) / np.pi] * (count_a * count_b)
    table = np.array(small, dtype=float).reshape(-1, 3, 3)
    return Sources(table[:, 0].copy(), table[:, 1].copy(), table[:, 2].copy(), np.array(spread_m2), flux_lm)


@njit(cache=True)
def _illuminance(
    point: NDArray[np.float64], normal: NDArray[np.floating], sources: Sources, total: NDArray[np.float64]
) -> None:
    """Add to ``total`` (3,) the direct light of the sources, see ``LampShader.illuminance_lx``."""
    for source in range(sources.positions_m.shape[0]):
        arriving = arriving_per_m2(point, normal, sources, source)
        if arriving > 0.0:
            for k in range(3):
                total[k] += sources.intensity_cd[source, k] * arriving


@njit(cache=True)
def arriving_per_m2(point: NDArray[np.float64], normal: NDArray[np.floating], sources: Sources, source: int) -> float:
    """Return the lux on a surface per candela of a source, see ``LampShader.illuminance_lx``."""
    squared, along, ahead = 0.0, 0.0, 0.0
    for k in range(3):
        towards = sources.positions_m[source, k] - point[k]
        squared += towards * towards
        along += towards * normal[k]
        ahead -= towards * sources.facing[source, k]
    if along <= 0.0:
        return 0.0
    squared = max(squared, _NEAREST_M * _NEAREST_M)
    distance = np.sqrt(squared)
    leaving = max(ahead, 0.0) / distance if sources.spread_m2[source] > 0.0 else 1.0
    return leaving * along / distance / (squared + sources.spread_m2[source] * leaving**4)


@njit(cache=True)
def _illuminate(
    points_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    sources: Sources,
    indirect_lx: NDArray[np.float64],
    result: NDArray[np.float64],
) -> None:
    """Write the illuminance (N, 3) of points."""
    for n in range(points_m.shape[0]):
        result[n] = indirect_lx
        _illuminance(points_m[n], normals[n], sources, result[n])


@njit(cache=True)
def _shade(
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    normal: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    view: NDArray[np.float64],
    sources: Sources,
    indirect_lx: NDArray[np.float64],
    own_nit: NDArray[np.float64],
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance (H, 3, W).

    Args:
        view: (4, 3) the camera's place; the ray of the upper left pixel at depth 1; its change to the next pixel to the
            right and below.
        own_nit: (K, 3) luminances of the first K bodies, -1 for those that do not shine.
    """
    point, total = np.empty(3), np.empty(3)
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            depth = depth_m[row, column]
            if not depth < np.inf:
                radiance[row, :, column] = 0.0
                continue
            body = instance_id[row, column]
            if 0 <= body < own_nit.shape[0] and own_nit[body, 0] >= 0.0:
                radiance[row, :, column] = own_nit[body]
                continue
            for k in range(3):
                point[k] = view[0, k] + depth * (view[1, k] + column * view[2, k] + row * view[3, k])
                total[k] = indirect_lx[k]
            _illuminance(point, normal[row, column], sources, total)
            for k in range(3):
                radiance[row, k, column] = _LINEAR[base_colour_rgb[row, column, k]] * total[k] / np.pi
