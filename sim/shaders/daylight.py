"""Daylight: a sun that casts shadows, with the sky and the lit ground as ambient light.

For a surface with reflectance ``rho`` (linear base colour), normal ``n`` and the direction ``l`` towards
the sun

    E = sun * max(0, n . l) * lit + sky * (1 + n_z) / 2 + bounce * (1 - n_z) / 2
    L = rho * E / pi
    bounce = 0.2 * (sun * max(0, l_z) + sky)

with illuminances in lux, so the radiance L is a luminance in cd/m² for each of R, G and B. ``lit`` in [0,
1] is the share of a 2x2 neighbourhood of shadow-map texels that see the sun, weighted bilinearly
(percentage-closer filtering, Reeves et al. 1987).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import Camera, ray_of_pixel
from sim.render.row_stages import RowStage, light_picture
from sim.render.shadow_kernels import bounds_across, find_tiles
from sim.render.shadow_map import ShadowCaster
from sim.shaders.colour import LUMINANCE_WEIGHTS
from sim.shaders.daylight_kernels import DaylightArrays, ShadowArrays, new_daylight_scratch, shade_row
from sim.world import World

GROUND_REFLECTANCE = 0.2
SHADOW_REACH_M = 400.0
"""Shadows are drawn on surfaces up to this depth."""
_PROBE_STEP_PX = 16


@dataclass(frozen=True, slots=True)
class Sun:
    """The sun.

    Attributes:
        direction: from the scene towards the sun, world frame; any length > 0.
        illuminance_lx: on a surface perpendicular to it, >= 0.
        colour_rgb: relative linear R, G, B.
    """

    direction: tuple[float, float, float] | NDArray[np.float64]
    illuminance_lx: float
    colour_rgb: tuple[float, float, float] = (1.06, 1.0, 0.88)


class DaylightShader:
    """Lights G-buffers of one world, whichever renderer drew them."""

    lighting = RowStage(shade_row, new_daylight_scratch)

    def __init__(
        self,
        world: World,
        sun: Sun,
        sky_illuminance_lx: float,
        *,
        sky_colour_rgb: tuple[float, float, float] = (0.86, 1.0, 1.3),
    ) -> None:
        """Set the light.

        Args:
            sky_illuminance_lx: on level ground, >= 0.
            sky_colour_rgb: relative linear R, G, B.
        """
        direction = np.asarray(sun.direction, dtype=float)
        check("sun.direction", bool(np.linalg.norm(direction) > 0), "a vector of length > 0", sun.direction)
        check("sun.illuminance_lx", sun.illuminance_lx >= 0, "a number >= 0", sun.illuminance_lx)
        check("sky_illuminance_lx", sky_illuminance_lx >= 0, "a number >= 0", sky_illuminance_lx)
        towards_sun = direction / np.linalg.norm(direction)
        sun_lx = sun.illuminance_lx * _of_unit_luminance(sun.colour_rgb)
        sky_lx = sky_illuminance_lx * _of_unit_luminance(sky_colour_rgb)
        bounce_lx = GROUND_REFLECTANCE * (sun_lx * max(0.0, towards_sun[2]) + sky_lx)
        self._caster = ShadowCaster(world, towards_sun)
        self._light = (
            towards_sun.astype(np.float32),
            sun_lx.astype(np.float32),
            sky_lx.astype(np.float32),
            bounce_lx.astype(np.float32),
        )

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at
        pixel centres.
        """
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> DaylightArrays:
        """Return the present light in one camera's picture, for the row kernel.

        Args:
            depth_m: (H, W).
        """
        return DaylightArrays(*self._light, shadows_in_view(self._caster, depth_m, camera, T_world_camera))


def shadows_in_view(
    caster: ShadowCaster,
    depth_m: NDArray[np.float32],
    camera: Camera,
    T_world_camera: NDArray[np.float64],
) -> ShadowArrays:
    """Return the shadows in a camera's present view.

    Args:
        depth_m: (H, W); every 16th pixel of every 16th row determines the region of the map, all pixels its tiles.
    """
    position_m, R_world_camera = T_world_camera[:3, 3], T_world_camera[:3, :3]
    rays = ray_of_pixel(camera)
    across = caster.axes[:2]
    across_of_pixel = np.empty((2, 4))
    across_of_pixel[:, :3], across_of_pixel[:, 3] = across @ R_world_camera @ rays, across @ position_m
    low_m, high_m = np.empty(2), np.empty(2)
    probe_depth_m = depth_m[::_PROBE_STEP_PX, ::_PROBE_STEP_PX]
    bounds_across(probe_depth_m, _PROBE_STEP_PX, SHADOW_REACH_M, across_of_pixel, low_m, high_m)
    if not low_m[0] <= high_m[0]:
        low_m = high_m = across @ position_m
    region = caster.region(low_m, high_m)
    in_map = region.in_map
    from_pixel = np.empty((3, 4))
    from_pixel[:, :3] = in_map[:, :3] @ R_world_camera @ rays
    from_pixel[:, 3] = in_map[:, :3] @ position_m + in_map[:, 3]
    wanted = np.empty_like(region.arrays.drawn)
    find_tiles(depth_m, from_pixel, wanted)
    shadow_map = caster.draw(region, wanted)
    return ShadowArrays(
        shadow_map.height_m.ravel(),
        shadow_map.highest_m.ravel(),
        shadow_map.height_m.shape[0],
        from_pixel.astype(np.float32),
        np.float32(shadow_map.texel_m),
    )


def _of_unit_luminance(colour_rgb: tuple[float, float, float]) -> NDArray[np.float64]:
    colour = np.asarray(colour_rgb, dtype=float)
    return colour / float(colour @ LUMINANCE_WEIGHTS)
