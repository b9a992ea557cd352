"""A small made-up waterfront for tests of thermal pictures: sea, quay, sheds, and boats and people of boxes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.optics import PinholeCamera
from sim.pose import pose_on_ground
from sim.shaders.thermal.sea import Sea
from sim.shaders.thermal.shader import ThermalShader
from sim.thermal.heat import MATERIALS, Surface, course
from sim.thermal.waves import SeaState, SeaWaves
from sim.thermal.weather import Weather
from sim.world import Body, World
from tests.sim.demo_scene import box, ground

CAMERA = PinholeCamera(384, 288, 770.0)
SEA_LEVEL_M, WALL_X_M = -1.8, -15.0
LOOKS = {"quay": "concrete", "shed": "brick", "roof": "roof felt", "hull": "fibreglass", "car": "dark paint"}


def overview() -> NDArray[np.float64]:
    """Return T_world_camera of a camera 20 m up, aimed at the origin from x = -100 m."""
    ahead = np.array([100.0, 0.0, -20.0])
    ahead /= np.linalg.norm(ahead)
    right = np.array([0.0, -1.0, 0.0])
    T = np.eye(4)
    T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    T[:3, 3] = (-100.0, 0.0, 20.0)
    return T


def looks(rng: np.random.Generator, part: int, spread: float, side: int = 256) -> Texture:
    """Return a texture of one part with blotches."""
    coarse = np.kron(rng.normal(0.0, 1.0, (side // 16, side // 16)), np.ones((16, 16)))
    fine = rng.normal(0.0, 0.5, (side, side))
    green = np.clip(128 + spread * (coarse + fine), 1, 255)
    return Texture(np.stack([np.full_like(green, part), green, np.zeros_like(green)], -1).astype(np.uint8), smooth=True)


def plain(*parts: int) -> Texture:
    """Return a palette of six parts, for the faces of a box."""
    rgb = np.zeros((1, 6, 3), np.uint8)
    rgb[0, :, 0], rgb[0, :, 1] = np.resize(parts, 6), 128
    return Texture(rgb)


class Waterfront:
    """The world, its shader, and its movable bodies."""

    def __init__(self, weather: Weather, rng: np.random.Generator, *, boats: int = 5, people: int = 6) -> None:
        self.world, self.weather = World(), weather
        add = self.world.add
        self.sea = add(ground(400.0, plain(0)), self.tide(0.0), name="sea", category="ground", movable=True)
        quay = _offset(ground(230.0, looks(rng, 0, 12.0, 512)), (100.0, 0.0, 0.0))
        self._fixed = {"quay": [add(quay, np.eye(4), name="quay", category="ground")]}
        wall = box((1.0, 230.0, 6.0), plain(0))
        self._fixed["quay"].append(add(wall, _at(WALL_X_M + 0.5, 0.0, -6.001), name="wall", category="building"))
        self._fixed["shed"] = [
            add(box((14.0, 18.0, 6.0), plain(0)), _at(38.0, y, 0.0), name="shed", category="building")
            for y in (-30.0, -8.0, 14.0, 36.0)
        ]
        self._fixed["roof"] = [
            add(box((15.0, 19.0, 0.4), plain(0)), _at(38.0, y, 6.0), name="roof", category="building")
            for y in (-30.0, -8.0, 14.0, 36.0)
        ]
        self._fixed["car"] = [
            add(box((1.8, 4.2, 1.5), plain(0)), _at(12.0, y, 0.0), name="parked", category="vehicle")
            for y in (-12.0, -9.0, 7.0)
        ]
        self.boats = [
            add(box((3.0, 8.0, 1.8), plain(0)), np.eye(4), name=f"boat-{k}", category="boat", movable=True)
            for k in range(boats)
        ]
        self.people = [
            add(box((0.3, 0.5, 1.75), plain(0)), np.eye(4), name=f"person-{k}", category="person", movable=True)
            for k in range(people)
        ]
        self.shader = ThermalShader(self.world, 120.0)
        self.waves = SeaWaves(SeaState(wind_rad=2.0), rng)
        self.shader.sea = Sea(self.sea, self.waves, weather.sea_k)
        self.move_to(0.0)

    @staticmethod
    def tide(rise_m: float) -> NDArray[np.float64]:
        """Return the sea's pose."""
        return _at(-210.0, 0.0, SEA_LEVEL_M + rise_m)

    def set_hour(self, hour: float) -> None:
        """Set sun, air and temperatures."""
        names = list(LOOKS)
        surfaces = [Surface(MATERIALS[LOOKS[name]], 0.5 if name in ("shed", "hull") else 1.0) for name in names]
        shaded, sunlit = course(surfaces, self.weather, hour - 0.1, hour + 0.1).at(hour)
        self.shader.set_air(self.weather.air(hour))
        directions = self.weather.towards_sun(hour - np.array([0.0, 0.3, 0.8]))
        up = directions[:, 2] > 0
        self.shader.set_sun(list(directions[up]), list(np.array([0.5, 0.3, 0.2])[up]))
        bodies = {**self._fixed, "hull": self.boats}
        for name, cool, hot in zip(names, shaded, sunlit, strict=True):
            for body in bodies.get(name, []):
                self._paint(body, cool, hot)
        for body in self.people:
            self._paint(body, 302.0, 304.0)

    def move_to(self, time_s: float) -> None:
        """Move sea, boats and people to a time."""
        self.waves.time_s = time_s
        rise_m = 0.5 * np.sin(2 * np.pi * time_s / 44_712.0)
        self.world.move(self.sea, self.tide(rise_m))
        for k, boat in enumerate(self.boats):
            x, y = WALL_X_M - 3.5 - 4.0 * (k % 2), -14.0 + 7.0 * k
            self.world.move(boat, _at(x, y, SEA_LEVEL_M + rise_m - 0.6 + 0.03 * np.sin(1.7 * time_s + k)))
        for k, person in enumerate(self.people):
            x, y = -10.0 + 9.0 * k, -15.0 + (1.3 * time_s + 11.0 * k) % 30.0
            self.world.move(person, pose_on_ground(x, y, 0.3 * k))

    def _paint(self, body: Body, cool_k: float, hot_k: float) -> None:
        self.shader.set_parts(body, np.array([cool_k]), np.array([hot_k]), np.array([0.94]))


def _at(x_m: float, y_m: float, z_m: float) -> NDArray[np.float64]:
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, z_m
    return T


def _offset(mesh: TexturedMesh, by_m: tuple[float, float, float]) -> TexturedMesh:
    moved = (mesh.vertices_m + np.array(by_m)).astype(np.float32)
    return TexturedMesh(moved, mesh.normals, mesh.uv, mesh.faces, mesh.texture)
