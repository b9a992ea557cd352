"""A building's light: baked once from its panels, and set to the light plan's strengths on each frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.building import LIGHT_GROUPS, SKY, SUN, Building
from scenarios.stereo_follow.light_plan import LightPlan
from scenarios.stereo_follow.panels import add_panel, bright_area
from sim.shaders.baked.bake import BakedLight, Panel, Sky, Source, bake_light, mean_reflectance
from sim.shaders.baked.shader import BakedLightShader
from sim.shaders.colour import LUMINANCE_WEIGHTS, black_body_rgb
from sim.shaders.daylight import Sun
from sim.world import World


@dataclass(frozen=True, eq=False)
class LitBuilding:
    """A building with its light, see ``baked_light``."""

    building: Building
    baked: BakedLight


def build(world: World, building: Building) -> BakedLight:
    """Add a building to a world and return its baked light."""
    first_index = len(world.bodies)
    for piece in building.panels:
        add_panel(world, piece)
    for mesh, T_world_tree in building.trees:
        world.add(mesh, T_world_tree, name="tree", category="tree")
    return baked_light(building, first_index)


@lru_cache(maxsize=1)
def baked_light(building: Building, first_index: int) -> BakedLight:
    """Bake the light of a building whose first panel is the body ``first_index`` of its world; the latest is kept."""
    lights: dict[str, list[Source]] = {group: [] for group in LIGHT_GROUPS}
    panels = []
    for index, piece in enumerate(building.panels, first_index):
        if piece.group:
            lights[piece.group].append(bright_area(index, piece))
        else:
            reflectance = mean_reflectance(piece.texture)
            panels.append(Panel(index, piece.corner_m, piece.side_a_m, piece.side_b_m, reflectance))
    sky = building.sky
    lights[SUN].append(Sun(sky.sun_direction, sky.sun_illuminance_lx, _colour(sky.sun_temperature_k)))
    lights[SKY].append(Sky(sky.luminance_nit, _colour(sky.temperature_k)))
    return bake_light(panels, lights)


def set_light(shader: BakedLightShader, plan: LightPlan, frame: int) -> None:
    """Set the light to that of a frame."""
    shader.set_strengths({group: float(strength[frame]) for group, strength in plan.strengths.items()})


def illuminance_lx(
    shader: BakedLightShader, places_m: NDArray[np.float64], viewer_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the illuminance (N,) on upright surfaces at places (N, 3) that face a viewer (3,)."""
    normals = viewer_m - places_m
    normals[:, 2] = 0.0
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    return shader.illuminance_lx(places_m, normals) @ LUMINANCE_WEIGHTS


def _colour(temperature_k: float) -> tuple[float, float, float]:
    red, green, blue = black_body_rgb(temperature_k).tolist()
    return red, green, blue
