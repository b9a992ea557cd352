"""A tank of water for tests."""

from __future__ import annotations

import numpy as np

from sim.meshes.facets import Facets, palette, swatch_uv
from sim.water_surface import RippledSurface, Ripples, draw_waves
from sim.world import World
from trackers.types import CameraModel

LOW_M, HIGH_M, LEVEL_M, RIM_M = (-0.3, -0.21), (0.3, 0.21), 0.12, 0.15
FLOOR, WALLS = 0, 1


def surface(slope_rms=0.03, seed=3, time_s=1.7):
    """Return water 12 cm deep over a floor at 0."""
    waves = draw_waves(Ripples(slope_rms), LEVEL_M, np.random.default_rng(seed))
    water = RippledSurface(waves, LOW_M, HIGH_M, LEVEL_M, LEVEL_M)
    water.time_s = time_s
    return water


def tank(balls_m=(), size_m=0.004):
    """Return a world of a pale floor, walls and small dark boxes that can move."""
    world = World()
    floor = Facets()
    floor.polygon([(-0.35, -0.26, 0), (0.35, -0.26, 0), (0.35, 0.26, 0), (-0.35, 0.26, 0)], swatch_uv(0, 1))
    world.add(floor.mesh(palette([(190, 186, 176)])), np.eye(4), name="floor", category="ground")
    walls = Facets()
    (x0, y0), (x1, y1), t = LOW_M, HIGH_M, 0.01
    for low, high in (
        ((x0 - t, y0 - t), (x0, y1 + t)),
        ((x1, y0 - t), (x1 + t, y1 + t)),
        ((x0 - t, y0 - t), (x1 + t, y0)),
        ((x0 - t, y1), (x1 + t, y1 + t)),
    ):
        walls.box((*low, 0.0), (*high, RIM_M), swatch_uv(0, 1))
    world.add(walls.mesh(palette([(225, 225, 222)])), np.eye(4), name="walls", category="wall")
    for k, place_m in enumerate(balls_m):
        box = Facets()
        box.box((-0.5 * size_m,) * 3, (0.5 * size_m,) * 3, swatch_uv(0, 1))
        T_world_box = np.eye(4)
        T_world_box[:3, 3] = place_m
        world.add(box.mesh(palette([(40, 36, 30)])), T_world_box, name=f"ball {k}", category="ball", movable=True)
    return world


def looking(angle_deg, focal_px=1200.0, distance_m=1.1, width_px=640, height_px=480):
    """Return a camera that looks at the tank, at an angle from straight down."""
    angle = np.radians(angle_deg)
    position = np.array([-distance_m * np.sin(angle), 0.03, LEVEL_M + distance_m * np.cos(angle)])
    ahead = np.array([0.0, 0.0, 0.05]) - position
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (1.0, 0.0, 0.0))
    right /= np.linalg.norm(right)
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = np.column_stack([right, np.cross(ahead, right), ahead])
    T_world_camera[:3, 3] = position
    return CameraModel(width_px, height_px, focal_px), T_world_camera
