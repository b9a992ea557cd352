"""Shader of baked light, from G-buffer to radiance.

    L = rho E / pi

with E on panels from their maps and the sun, on other bodies from the ambient cubes around them (``light_grid``) and
the sun. Moving bodies cast shadows in the sun, and darken the ground on which they stand.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import PinholeCamera, rays
from sim.render.row_stages import RowStage, light_picture
from sim.render.shadow_map import BLOCK, ShadowCaster
from sim.shaders.baked.bake import BakedLight
from sim.shaders.baked.direct import sun_share
from sim.shaders.baked.light_grid import light_up_places
from sim.shaders.baked.shader_kernels import BakedArrays, add_up, baked_row, new_baked_scratch
from sim.shaders.colour import black_body_rgb
from sim.shaders.contact_shadows import STEP_M, ContactShadows
from sim.shaders.daylight import NOT_IN_MAP, ShadowArrays, shadows_in_view
from sim.shaders.lamps import BrightArea
from sim.world import World

_FLOOR_RANGE_M = 0.3
_SHADOW_TEXELS = 512
_NO_SHADOWS = ShadowArrays(
    np.zeros(BLOCK * BLOCK, np.float32), np.zeros(1, np.float32), BLOCK, np.zeros((3, 4), np.float32), np.float32(1.0)
)
_AROUND = np.array([(1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)]) / np.sqrt(3)
"""Places in a body where the sun is sampled, in shares of its half size."""


class BakedLightShader:
    """Lights G-buffers of one world."""

    lighting = RowStage(baked_row, new_baked_scratch)

    def __init__(
        self, world: World, baked: BakedLight, *, shadow_texels: int = _SHADOW_TEXELS, panels_raised: bool = True
    ) -> None:
        """Set all groups to full strength. ``world`` already holds all its bodies, also the moving ones.

        Args:
            shadow_texels: side of the moving bodies' shadow map, see ``ShadowCaster``.
            panels_raised: whether panels too are compared with the shadow map as if they lay higher by its bias. Only
                moving bodies need this, which are in the map; a shadow on a raised floor begins beside the feet.
        """
        self._world, self._baked = world, baked
        count = len(world.bodies)
        geometry = baked.geometry
        self._panel = np.full(count, -1, np.int32)
        for number, panel in enumerate(baked.panels):
            if panel.instance_id >= 0:
                self._panel[panel.instance_id] = number
        areas = [
            (area, group)
            for group, sources in enumerate(baked.groups.values())
            for area in sources
            if isinstance(area, BrightArea)
        ]
        self._shining = np.array([area.instance_id for area, _ in areas], dtype=np.int64)
        self._shining_group = np.array([group for _, group in areas], dtype=np.int64)
        full_nit = [area.luminance_nit * black_body_rgb(area.temperature_k) for area, _ in areas]
        self._full_nit = np.array(full_nit, dtype=float).reshape(-1, 3)
        self._others = np.setdiff1d(np.flatnonzero(self._panel < 0), self._shining)
        self._centre_m = np.ones((len(self._others), 4))
        self._half_m = np.empty((len(self._others), 3))
        for n, other in enumerate(self._others):
            vertices_m = world.bodies[other].mesh.vertices_m.astype(float)
            self._centre_m[n, :3] = 0.5 * (vertices_m.min(axis=0) + vertices_m.max(axis=0))
            self._half_m[n] = 0.5 * np.ptp(vertices_m, axis=0)
        # Rows of u and v of every panel, and their values at its corner.
        self._across = np.stack(
            [side / (side**2).sum(axis=1, keepdims=True) for side in (geometry.side_a_m, geometry.side_b_m)], axis=1
        )
        self._start = (self._across * geometry.corner_m[:, None]).sum(axis=2)
        self._maps = np.stack(baked.where[:3], axis=1).astype(np.int32)
        self._group_maps = np.zeros((*baked.maps_lx.shape[:2], 4), np.float32)
        self._group_maps[..., :3] = baked.maps_lx / np.pi
        self._group_cubes = baked.cubes_lx / np.float32(np.pi)
        self._contact = ContactShadows(world, baked.grid)
        self._is_floor = (geometry.normal[:, 2] > 0.9) & (
            abs(geometry.corner_m[:, 2] - self._contact.ground_m) < _FLOOR_RANGE_M
        )
        floor_m = geometry.corner_m[self._is_floor, 2]
        rise_m = np.stack([geometry.side_a_m[self._is_floor, 2], geometry.side_b_m[self._is_floor, 2]])
        self._floor_m = np.array(
            [
                (floor_m + np.minimum(rise_m, 0.0).sum(axis=0)).min(initial=self._contact.ground_m),
                (floor_m + np.maximum(rise_m, 0.0).sum(axis=0)).max(initial=self._contact.ground_m),
            ]
        )
        self._sun_maps = np.zeros((len(baked.panels), 3), np.int32)
        self._cosine = self._shadow_cosine = np.zeros(len(baked.panels), np.float32)
        self._towards_sun = np.array([0.0, 0.0, 1.0])
        self._caster: ShadowCaster | None = None
        if baked.sun is not None:
            self._sun_maps = np.stack(baked.sun.where[:3], axis=1).astype(np.int32)
            self._towards_sun = baked.sun.towards
            self._cosine = np.maximum(geometry.normal @ self._towards_sun, 0.0).astype(np.float32)
            self._shadow_cosine = self._cosine if panels_raised else np.full_like(self._cosine, NOT_IN_MAP)
            if any(body.movable for body in world.bodies):
                self._caster = ShadowCaster(world, self._towards_sun, shadow_texels, casting="movers")
        self._cubes = np.zeros((count, 6, 3), np.float32)
        self._body_sun = np.zeros(count, np.float32)
        self._strengths = dict.fromkeys(baked.groups, 1.0)
        self._light = np.empty(self._group_maps.shape[1:], np.float32)
        self._place_cubes = np.empty(self._group_cubes.shape[1:], np.float32)
        self._sum_up()

    def set_strengths(self, strengths: Mapping[str, float]) -> None:
        """Set the strengths of groups, 1 as baked; groups not named stay as they are.

        Raises:
            ValueError: for an unknown group or a negative strength.
        """
        for name, strength in strengths.items():
            check("strengths", name in self._strengths, f"groups of {', '.join(self._strengths)}", name)
            check(f"strengths[{name!r}]", strength >= 0, "a number >= 0", strength)
        if all(self._strengths[name] == strength for name, strength in strengths.items()):
            return
        self._strengths.update(strengths)
        self._sum_up()

    def _sum_up(self) -> None:
        baked = self._baked
        weights = np.array(list(self._strengths.values()), dtype=np.float32)
        add_up(weights, self._group_maps.reshape(len(weights), -1), self._light.reshape(-1))
        add_up(weights, self._group_cubes.reshape(len(weights), -1), self._place_cubes.reshape(-1))
        self._sun = np.zeros(3, np.float32)
        if baked.sun is not None:
            self._sun = (weights[baked.sun.group] * baked.sun.square_lx / np.pi).astype(np.float32)
        self._sky = (weights[baked.sky_group] * baked.sky if baked.sky_group >= 0 else baked.sky).astype(np.float32)
        self._own_nit = np.full((len(self._world.bodies), 3), -1.0, np.float32)
        self._own_nit[self._shining] = weights[self._shining_group, None] * self._full_nit
        self._poses_lit = np.empty((0, 4, 4))

    def illuminance_lx(self, points_m: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the illuminance (N, 3), lux of R, G and B, of surfaces at points (N, 3) with unit normals (N, 3).

        From the ambient cubes around and from the sun; moving bodies cast no shadow.
        """
        cubes, share = self._light_at(np.asarray(points_m, dtype=float), np.zeros((len(points_m), 3)))
        side = np.where(normals > 0, 0, 3) + np.arange(3)
        lx = (normals[..., None] ** 2 * cubes[np.arange(len(cubes))[:, None], side]).sum(axis=1)
        facing = np.maximum(normals @ self._towards_sun, 0.0)
        result: NDArray[np.float64] = np.pi * (lx + (share * facing)[:, None] * self._sun.astype(float))
        return result

    def shade(
        self, gbuffer: GBuffer, camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at pixel centres.

        Bright areas and the sky have their own.
        """
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> BakedArrays:
        """Return the present light in one camera's picture, for the row kernel.

        Args:
            depth_m: (H, W).
        """
        self._light_movers()
        corner, right, down = rays(camera, T_world_camera, np.array([(0.5, 0.5), (1.5, 0.5), (0.5, 1.5)]))
        view = np.stack([corner, right - corner, down - corner, T_world_camera[:3, 3]], axis=1)
        place = (self._across.reshape(-1, 3) @ view).reshape(*self._start.shape, 4)
        place[..., 3] -= self._start
        contact = self._contact
        rows, columns = contact.left.shape
        in_samples = view[:2].copy()
        in_samples[:, 3] -= contact.first_m
        in_samples /= STEP_M * np.array([[columns - 1], [rows - 1]])
        casts = self._caster is not None and bool(self._sun.any())
        shadows = _NO_SHADOWS
        if casts and self._caster is not None:
            shadows = shadows_in_view(self._caster, depth_m, camera, T_world_camera)
        sun_shares = self._baked.sun.share if self._baked.sun is not None else np.empty(0, np.float32)
        return BakedArrays(
            self._panel,
            self._own_nit,
            place.reshape(-1, 8).astype(np.float32),
            self._maps,
            self._light,
            self._sun_maps,
            sun_shares,
            self._cosine,
            self._shadow_cosine,
            self._sun,
            self._towards_sun.astype(np.float32),
            casts,
            shadows,
            self._cubes,
            self._body_sun,
            self._is_floor,
            contact.left.reshape(-1),
            columns,
            in_samples.reshape(1, 8).astype(np.float32),
            contact.columns(self._floor_m, camera, T_world_camera),
            self._sky,
            view[:, :3].T.astype(np.float32),
        )

    def _light_movers(self) -> None:
        """Compute the light at the present poses of all bodies that are no panels."""
        poses = self._world.poses
        if np.array_equal(poses, self._poses_lit):
            return
        self._poses_lit = poses.copy()
        self._contact.move(poses)
        others = poses[self._others]
        centre_m = np.einsum("bij,bj->bi", others[:, :3], self._centre_m)
        half_m = np.einsum("bij,bj->bi", np.abs(others[:, :3, :3]), self._half_m)
        self._cubes[self._others], self._body_sun[self._others] = self._light_at(centre_m, half_m)

    def _light_at(
        self, places_m: NDArray[np.float64], half_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return ambient cubes (N, 6, 3) at places (N, 3) and shares of the sun (N,) in boxes of half sizes there."""
        baked = self._baked
        cubes, share = np.zeros((len(places_m), 6, 3), np.float32), np.zeros(len(places_m), np.float32)
        light_up_places(baked.obstacles, baked.grid, self._place_cubes, places_m, cubes)
        if self._sun.any() and len(places_m):
            around_m = (places_m[:, None] + half_m[:, None] * _AROUND).reshape(-1, 3)
            shares = np.empty(len(around_m), np.float32)
            sun_share(baked.obstacles, self._towards_sun, around_m, np.zeros((1, 3)), shares)
            share = shares.reshape(-1, len(_AROUND)).mean(axis=1)
        return cubes, share
