"""Thermal radiance of a world: each part of each body has a temperature, in the shade and in the sun.

A mesh in a thermal world carries no visible colour but its thermal looks. Red is the index of the part of its body, 0
to 15; green the fine variation of that part's temperature, 128 for none, ``VARIATION_K`` for each step; blue is 0. So a
G-buffer of either renderer carries them. (A smooth texture must have the same red everywhere.)

For a surface with emissivity e and normal n at distance d

    T = T_shade + (T_sun - T_shade) * exposure + variation
    L_0 = e B(T) + (1 - e) (sky (1 + n_z) / 2 + ground (1 - n_z) / 2)
    L = L_0 exp(-a d) + B(T_air) (1 - exp(-a d))

B is the radiance of a black body in the band. The exposure is the weighted sum of ``lit * max(0, n . l)`` over several
positions l of the sun in the past hour: stone remembers. What never moves casts shadows. The sea is that of
``sim.shaders.thermal.sea``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import Camera, ray_of_pixel
from sim.render.raster import Raster
from sim.render.row_stages import RowStage, finish_rows, light_picture
from sim.shaders.thermal.glitter import NO_GLITTER, glitter_arrays
from sim.shaders.thermal.kernels import (
    PARTS,
    SKY_CELLS,
    KeptPicture,
    ThermalArrays,
    new_thermal_scratch,
    thermal_row,
)
from sim.shaders.thermal.mirror import NO_MIRROR, MirrorArrays, image_of, mirror_arrays, rows_mirrored
from sim.shaders.thermal.sea import NO_SEA, Sea, sea_arrays
from sim.shaders.thermal.sea_tables import radiance_table
from sim.shaders.thermal.sun import Suns
from sim.thermal.radiance import TABLE, band_radiance
from sim.thermal.sky import Air, sky_radiance
from sim.world import Body, World

_VIEWS_KEPT = 4
"""A picture's and its mirror's, of two cameras."""
_LEVEL_STEP_M = 0.05
"""The mirror's level follows the tide in steps: what does not move is then drawn on it once."""
_NEVER = np.float32(-1.0)


class ThermalShader:
    """Gives G-buffers of one world their thermal radiance, whichever renderer drew them.

    Attributes:
        sea: None for a world without.
    """

    lighting = RowStage(thermal_row, new_thermal_scratch, channels=1)

    def __init__(self, world: World, shadow_reach_m: float, air: Air | None = None) -> None:
        """Start with everything as warm as the air, no sun and no sea.

        Args:
            shadow_reach_m: shadows are cast by and on what is nearer than this to the world's origin.
        """
        self._world, self._suns = world, Suns(world, shadow_reach_m)
        self._raster = Raster(world)
        self.sea: Sea | None = None
        self._kept: dict[tuple[Camera, bytes], KeptPicture] = {}
        self._table_of: tuple[Air, float, float] | None = None
        self._table = NO_SEA.radiance
        self._parts = np.empty((3, 0, PARTS), np.float32)
        self._moves = np.empty(0, np.bool_)
        self._version = 0
        self.set_air(air or Air())

    def set_parts(
        self,
        bodies: Body | Sequence[Body],
        shaded_k: NDArray[np.float64],
        sunlit_k: NDArray[np.float64],
        emissivity: NDArray[np.float64],
    ) -> None:
        """Set the temperatures of the first P <= 16 parts of a body, or of several alike, and their emissivity.

        Args:
            shaded_k, sunlit_k: (P,), out of the sun and facing it.
            emissivity: (P,) in [0, 1].
        """
        count = len(shaded_k)
        check("shaded_k", 0 < count <= PARTS, f"1 to {PARTS} parts", count)
        self._make_room()
        alike = [bodies] if isinstance(bodies, Body) else bodies
        parts = np.stack([shaded_k, np.asarray(sunlit_k, dtype=float) - shaded_k, emissivity]).astype(np.float32)
        index = [body.index for body in alike]
        if not (self._parts[:, index, :count] == parts[:, None]).all():
            self._parts[:, index, :count] = parts[:, None]
            self._version += not all(body.movable for body in alike)

    def set_air(self, air: Air) -> None:
        """Set the air and the sky; what reflects little reflects these and a ground as warm as the air."""
        self._air = air
        self._version += 1
        sky = sky_radiance(air, np.linspace(0.0, 1.0, SKY_CELLS))
        sine = np.linspace(0.0, 1.0, 65)[1:] - 1.0 / 128
        mean = float((2.0 * sine * sky_radiance(air, sine)).mean())
        black = float(band_radiance(air.temperature_k))
        self._sky = sky.astype(np.float32)
        self._around = np.array([mean, black], np.float32)
        self._air_arrays = np.array([air.attenuation_per_m, black], np.float32)

    def set_sun(self, towards_sun: Sequence[NDArray[np.float64]], weights: Sequence[float]) -> None:
        """Set the positions of the sun that surfaces remember.

        Args:
            towards_sun: S unit vectors (3,), the latest one first: it glitters on the sea. None at night.
            weights: S numbers; all of them together should be 1.
        """
        if self._suns.set(towards_sun, weights):
            self._kept.clear()
        self._version += 1

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, 1, W) float32 in W/(m² sr) of a G-buffer sampled at pixel centres."""
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> ThermalArrays:
        """Return the present temperatures in one camera's picture, for the row kernel."""
        light = self._dry_light(camera, T_world_camera)
        if self.sea is None:
            return light
        mirror = self._mirror(self.sea, depth_m, camera, T_world_camera)
        suns = self._suns.arrays.towards
        sun = glitter_arrays(suns[0], self._air) if len(suns) else NO_GLITTER
        return light._replace(sea=sea_arrays(self.sea, self._sea_table(self.sea), mirror, sun))

    def _mirror(
        self, sea: Sea, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> MirrorArrays:
        """Return what the sea mirrors."""
        tide_m = float(self._world.poses[sea.body.index, 2, 3])
        image, T_world_image = image_of(camera, T_world_camera, _LEVEL_STEP_M * round(tide_m / _LEVEL_STEP_M))
        rows = rows_mirrored(depth_m, camera, T_world_camera, tide_m)
        if rows == 0:
            return NO_MIRROR
        seen = self._raster.visible(image, T_world_image)
        light = self._dry_light(image, T_world_image)
        # The way there is nearly that to the water, for which the picture itself accounts.
        light = light._replace(air=light.air * np.array([0.0, 1.0], np.float32))
        radiance = np.empty((rows, 1, image.width_px), np.float32)
        finish_rows(self._raster.resolving, seen, np.arange(rows), self.lighting, light, radiance)
        return mirror_arrays(image, camera, seen.depth_m[:rows], radiance[:, 0])

    def _dry_light(self, camera: Camera, T_world_camera: NDArray[np.float64]) -> ThermalArrays:
        """Return ``row_light`` of a world without a sea."""
        self._make_room()
        shaded_k, warmth_k, emissivity = self._parts.reshape(3, -1)
        return ThermalArrays(
            shaded_k,
            warmth_k,
            emissivity,
            _PLANCK,
            self._sky,
            self._around,
            self._air_arrays,
            (T_world_camera[:3, :3] @ ray_of_pixel(camera)).astype(np.float32),
            T_world_camera[:3, 3].astype(np.float32),
            np.float32(1.0 / camera.focal_px),
            self._moves,
            self._version,
            self._suns.arrays,
            self._kept_picture(camera, T_world_camera),
            NO_SEA,
        )

    def _make_room(self) -> None:
        """Give bodies that are new the temperature of the air."""
        new = len(self._world.bodies) - self._parts.shape[1]
        if new > 0:
            fresh = np.zeros((3, new, PARTS), np.float32)
            fresh[0], fresh[2] = self._air.temperature_k, 0.95
            self._parts = np.concatenate([self._parts, fresh], axis=1)
            self._moves = np.array([body.movable for body in self._world.bodies])
            self._kept.clear()

    def _kept_picture(self, camera: Camera, T_world_camera: NDArray[np.float64]) -> KeptPicture:
        key = camera, T_world_camera.tobytes()
        if key not in self._kept:
            if len(self._kept) >= _VIEWS_KEPT:
                del self._kept[next(iter(self._kept))]
            shape = camera.height_px, camera.width_px
            self._kept[key] = KeptPicture(
                np.full(shape, _NEVER),
                np.full(shape, -2, np.int32),
                np.zeros((shape[0], len(self._suns.arrays.weight), shape[1]), np.float32),
                np.zeros(shape, np.float32),
                np.zeros(shape, np.float32),
                np.full(shape[0], -1),
            )
        return self._kept[key]

    def _sea_table(self, sea: Sea) -> NDArray[np.float32]:
        wanted = self._air, sea.temperature_k, sea.waves.state.fine_slope
        if wanted != self._table_of:
            self._table_of, self._table = wanted, radiance_table(*wanted)
        return self._table


_PLANCK = TABLE.astype(np.float32)
