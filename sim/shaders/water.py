"""Light in and on water: caustics, shadows, veil, and what the rippled surface reflects.

Panels above the water (tubes, lit ceilings, windows) and uniform light from all around shine on it. A surface of
reflectance ``rho`` (linear base colour) in the water, ``d`` below it and seen along ``s`` of it, has the radiance

    L = (1 - F) / n² (rho E / pi X + V (1 - X)) + F M,    X = exp(-(a + b) s - K d),    K = 1.2 (a + 0.3 b)

with absorption ``a`` and scattering ``b`` per metre, the share ``F`` that the surface reflects (Fresnel) and what is
mirrored there, ``M``. ``E`` is the light that enters, with caustics and shadows, see ``sim.shaders.caustics``. The veil
``V = b / (a + b + K) E_0 / (4 pi)`` is light scattered once, alike in all directions, of twice the light that enters:
about as much comes back from a pale floor. K is the usual estimate for daylight (Kirk, Light and Photosynthesis in
Aquatic Ecosystems, 2011, chapter 6), whose constants depend on the particles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.checks import check, check_types, check_within
from sim.gbuffer import GBuffer
from sim.optics import Camera
from sim.render.refraction import water_rays
from sim.render.row_stages import RowStage, light_picture
from sim.shaders.black_body import black_body_rgb
from sim.shaders.caustics import FloorLight, LightThroughSurface
from sim.shaders.water_kernels import WaterLight, new_water_scratch, shade_row
from sim.shaders.water_mirrors import PanelArrays, mirror_panels
from sim.water_surface import RippledSurface
from sim.world import World

_PATCHES = 24
"""Patches along each side of a panel, over which its light is summed."""
_BACK_FROM_SURFACE = 0.48
"""Share of diffuse light from below that the surface sends back, for an index of 1.33."""


@dataclass(frozen=True, slots=True)
class Water:
    """What is in the water.

    Attributes:
        scattering_per_m: by particles, in [0, 60]: 0.2 is clear, 3 a little cloudy, 8 murky for a tank of 12 cm.
        absorption_per_m: of R, G and B, each in [0, 20]; the default is that of pure water.
        particles_rgb: share of scattered light of each colour that particles do not absorb, in [0, 1].
        floor_reflectance: mean of floor and walls, in [0, 0.95], which light up the water from below.
    """

    scattering_per_m: float = 0.2
    absorption_per_m: tuple[float, float, float] = (0.34, 0.06, 0.01)
    particles_rgb: tuple[float, float, float] = (0.92, 0.95, 0.86)
    floor_reflectance: float = 0.5

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "scattering_per_m", 0.0, 60.0)
        check_within(self, "floor_reflectance", 0.0, 0.95)
        for name, high in (("absorption_per_m", 20.0), ("particles_rgb", 1.0)):
            got = getattr(self, name)
            check(name, all(0.0 <= each <= high for each in got), f"three numbers in [0, {high:g}]", got)


@dataclass(frozen=True, slots=True)
class Panel:
    """A bright rectangle above the water: a tube, a lit ceiling panel or a window. It is mirrored, but not drawn.

    Attributes:
        middle_m, side_a_m, side_b_m: its middle and two sides (3,) at a right angle, world frame; both faces shine.
        luminance_nit: >= 0.
        temperature_k: colour temperature, see ``black_body_rgb``.
        panes: of a window, along side a and b; cross bars between them are dark.
        bar_share: width of a bar or frame relative to that of a pane, in [0, 1).
    """

    middle_m: tuple[float, float, float]
    side_a_m: tuple[float, float, float]
    side_b_m: tuple[float, float, float]
    luminance_nit: float
    temperature_k: float = 5000.0
    panes: tuple[int, int] = (1, 1)
    bar_share: float = 0.0

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "luminance_nit", 0.0)
        check("panes", min(self.panes) >= 1, "two numbers >= 1", self.panes)
        check("bar_share", 0.0 <= self.bar_share < 1.0, "a number in [0, 1)", self.bar_share)
        a, b = np.array(self.side_a_m), np.array(self.side_b_m)
        lengths = float(np.linalg.norm(a) * np.linalg.norm(b))
        is_rectangle = lengths > 0 and abs(float(a @ b)) < 1e-6 * lengths
        check("side_a_m, side_b_m", is_rectangle, "sides of a rectangle", (self.side_a_m, self.side_b_m))


class WaterShader:
    """Lights G-buffers of one world with water in it, as ``sim.render.refraction.ThroughWater`` draws them."""

    lighting = RowStage(shade_row, new_water_scratch)

    def __init__(
        self,
        world: World,
        surface: RippledSurface,
        water: Water,
        panels: Sequence[Panel],
        ambient_lx: float,
        *,
        ambient_temperature_k: float = 5000.0,
    ) -> None:
        """Set the light.

        Args:
            surface: the one that is looked through; its ``time_s`` counts.
            panels: each wholly above the water.
            ambient_lx: uniform light from all around, on a level surface, >= 0.
        """
        check("ambient_lx", ambient_lx >= 0, "a number >= 0", ambient_lx)
        for panel in panels:
            lowest_m = panel.middle_m[2] - 0.5 * (abs(panel.side_a_m[2]) + abs(panel.side_b_m[2]))
            check("panels", lowest_m > surface.level_m, f"above the water at {surface.level_m} m", lowest_m)
        self._surface = surface
        lights = [_through_surface(panel, surface) for panel in panels]
        lights.append(_ambient(ambient_lx, surface.refractive_index))
        self._floor = FloorLight(world, surface, lights)
        lx = np.array([light.illuminance_lx for light in lights])
        rgb = np.stack(
            [*(black_body_rgb(panel.temperature_k) for panel in panels), black_body_rgb(ambient_temperature_k)]
        )
        self._entering_lx = float(lx.sum()) / (1.0 - _BACK_FROM_SURFACE * water.floor_reflectance)
        colour = lx @ rgb / lx.sum() if lx.sum() > 0 else np.ones(3)
        absorbed, scattered = np.array(water.absorption_per_m), water.scattering_per_m
        down = 1.2 * (absorbed + 0.3 * scattered)
        along = absorbed + scattered
        share = np.divide(scattered, along + down, out=np.zeros(3), where=along + down > 0)
        veil = np.array(water.particles_rgb) * share * 2.0 * self._entering_lx * colour / (4.0 * np.pi)
        self._medium = np.stack([colour * self._entering_lx / np.pi, veil, along, down]).astype(np.float32)
        self._direct = self._floor.mean_direction()
        self._bounce = water.floor_reflectance
        self._air = (colour * float(lx.sum()) / np.pi).astype(np.float32)
        self._mirrored = (ambient_lx * black_body_rgb(ambient_temperature_k) / np.pi).astype(np.float32)
        self._panels = _panel_arrays(panels)

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at centres."""
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> WaterLight:
        """Return the light of the present moment, see ``RowShader``."""
        rays = water_rays(self._surface, camera, T_world_camera)
        return WaterLight(
            rays.nodes,
            rays.position_m.astype(np.float32),
            rays.matrix.astype(np.float32),
            self._floor.extent(),
            self._floor.maps(),
            self._medium,
            self._direct,
            np.float32(self._bounce),
            self._air,
            self._mirrored,
            self._panels,
            *mirror_panels(rays, self._panels),
        )


def _through_surface(panel: Panel, surface: RippledSurface) -> LightThroughSurface:
    """Return what enters the water at rest in the middle of its rectangle."""
    index = surface.refractive_index
    steps = (np.arange(_PATCHES) + 0.5) / _PATCHES - 0.5
    a, b = (side.ravel() for side in np.meshgrid(steps, steps))
    side_a, side_b = np.array(panel.side_a_m), np.array(panel.side_b_m)
    middle = np.array([*(0.5 * (surface.low_m + surface.high_m)), surface.level_m])
    towards = np.array(panel.middle_m) + a[:, None] * side_a + b[:, None] * side_b - middle
    distance = np.linalg.norm(towards, axis=1)
    across = np.cross(side_a, side_b)
    cosine = towards[:, 2] / distance
    leaving = np.abs(towards @ across) / distance
    lux = panel.luminance_nit * leaving * cosine / distance**2 / len(a)
    bent = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    reflected = 0.5 * (
        ((cosine - index * bent) / (cosine + index * bent)) ** 2
        + ((index * cosine - bent) / (index * cosine + bent)) ** 2
    )
    lux *= (1.0 - reflected) * (1.0 - panel.bar_share) ** 2
    run = -towards[:, :2] / distance[:, None] / index / bent[:, None]
    weight = lux / lux.sum() if lux.sum() > 0 else np.full(len(a), 1.0 / len(a))
    mean = weight @ run
    return LightThroughSurface(float(lux.sum()), mean, np.sqrt(weight @ (run - mean) ** 2))


def _ambient(ambient_lx: float, index: float) -> LightThroughSurface:
    """Return uniform light from above: 7 % are reflected; the tangent of the bent rays is uniform in its square."""
    widest = 1.0 / np.sqrt(index**2 - 1.0)
    return LightThroughSurface(0.93 * ambient_lx, np.zeros(2), np.full(2, 0.5 * widest))


def _panel_arrays(panels: Sequence[Panel]) -> PanelArrays:
    frames = np.empty((len(panels), 3, 3), np.float32)
    for frame, panel in zip(frames, panels, strict=True):
        frame[0] = panel.middle_m
        for k, side in enumerate((np.array(panel.side_a_m), np.array(panel.side_b_m)), 1):
            frame[k] = side / (side @ side)
    nit = [panel.luminance_nit * black_body_rgb(panel.temperature_k) for panel in panels]
    return PanelArrays(
        frames,
        np.array(nit, np.float32).reshape(-1, 3),
        np.array([panel.panes for panel in panels], np.float32).reshape(-1, 2),
        np.array([panel.bar_share for panel in panels], np.float32),
    )
