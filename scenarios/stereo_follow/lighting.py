"""The light of an episode: its plan, drawn before the first picture, and the baked light of the building."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from scenarios.stereo_follow.building import CORRIDOR_LIGHTS, HALL_LIGHTS, LIGHT_GROUPS, SKY, SUN, WINDOWS, Building
from scenarios.stereo_follow.panels import add_panel, bright_area
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.truth import LightEvent
from sim.shaders.baked.bake import BakedLight, Panel, Sky, Source, bake_light, mean_reflectance
from sim.shaders.baked.shader import BakedLightShader
from sim.shaders.colour import LUMINANCE_WEIGHTS, black_body_rgb
from sim.shaders.daylight import Sun
from sim.world import World

NEW_S = 1.0
"""Time during which a change counts as new."""
_SUN_BEHIND_CLOUD = (0.05, 0.25)
_LAMP_EDGE_FRAMES = 0.7
_LARGEST_EXPONENT = 700.0
_FURNITURE = np.full(3, 0.3)
"""Reflectance of furniture for the light of a room."""


@dataclass(frozen=True, slots=True)
class LightPlan:
    """Light over F frames.

    Attributes:
        strengths: group -> (F,) of its full strength.
        switched: (F,) the lamp event within the last second at the target's place: ``lamp on``, ``lamp off`` or None.
    """

    strengths: dict[str, NDArray[np.float64]]
    switched: tuple[LightEvent | None, ...]


def draw_light_plan(preset: StereoFollow, places: tuple[str, ...], rng: np.random.Generator) -> LightPlan:
    """Draw the changes. Lamps at the target's current place are switched, and switched back after some seconds.

    Args:
        places: (F,) of the target.
    """
    frames, rate_hz = len(places), preset.rate_hz
    strengths = {group: np.ones(frames) for group in LIGHT_GROUPS}
    switched: list[LightEvent | None] = [None] * frames
    for begin in _spread(preset.lamp_events, 0.08, 0.8, frames, rng):
        group = CORRIDOR_LIGHTS if places[begin] == "corridor" else HALL_LIGHTS
        end = begin + int(rng.uniform(*preset.lamps_off_s) * rate_hz)
        # Lamps that are off already cannot be switched off.
        if (strengths[group][begin : end + 1] < 1.0).any() or places[begin] == "yard":
            continue
        strengths[group][begin:end] = rng.uniform(*preset.lamps_left_on)
        _note(switched, begin, "lamp off", rate_hz)
        if end < frames and places[end] == places[begin]:
            _note(switched, end, "lamp on", rate_hz)
    for group in (CORRIDOR_LIGHTS, HALL_LIGHTS):
        strengths[group] = gaussian_filter1d(strengths[group], _LAMP_EDGE_FRAMES, mode="nearest")
    cloud = np.zeros(frames)
    for begin in _spread(preset.clouds, -0.2, 0.9, frames, rng):
        cloud[max(begin, 0) : max(begin + int(rng.uniform(*preset.cloud_s) * rate_hz), 0)] = 1.0
    cloud = gaussian_filter1d(cloud, preset.cloud_edge_s * rate_hz, mode="nearest")
    strengths[SUN] = 1.0 - (1.0 - rng.uniform(*_SUN_BEHIND_CLOUD)) * cloud
    strengths[WINDOWS] = 1.0 - (1.0 - preset.sky_behind_cloud) * cloud
    strengths[SKY] = strengths[WINDOWS]
    if preset.brightening_s > 0:
        strengths = {
            group: _held_back(strength, preset.brightening_s * rate_hz) for group, strength in strengths.items()
        }
    return LightPlan(strengths, tuple(switched))


def _spread(count: int, first: float, last: float, frames: int, rng: np.random.Generator) -> Iterator[int]:
    """Yield ``count`` frames between two shares of an episode, one from each of ``count`` equal parts."""
    for part in range(count):
        yield int((first + (last - first) * (part + rng.random()) / count) * frames)


def _held_back(strength: NDArray[np.float64], brightening_frames: float) -> NDArray[np.float64]:
    """Return strengths (F,) that grow by at most a factor of e in ``brightening_frames``."""
    held, most = strength.copy(), np.exp(min(1.0 / brightening_frames, _LARGEST_EXPONENT))
    for frame in range(1, len(held)):
        held[frame] = min(held[frame], held[frame - 1] * most)
    return held


def _note(switched: list[LightEvent | None], frame: int, event: LightEvent, rate_hz: float) -> None:
    for k in range(frame, min(frame + int(NEW_S * rate_hz), len(switched))):
        switched[k] = event


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
    for name, mesh, T_world_piece in building.furniture:
        world.add(mesh, T_world_piece, name=name, category="furniture")
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
    panels += [Panel(-1, corner_m, a_m, b_m, _FURNITURE) for corner_m, a_m, b_m in building.blockers]
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
