"""A small made-up town for tests of the picture: boxes, cones and a textured ground. Not the road town."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.world import World

_BOX_FACES = ((0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1))


def box(size_m: tuple[float, float, float], texture: Texture) -> TexturedMesh:
    """Return a box that stands on z = 0; face k has the k-th sixth of the texture's width."""
    vertices, normals, uv, faces = [], [], [], []
    half = 0.5 * np.array(size_m)
    for k, (axis, sign) in enumerate(_BOX_FACES):
        normal = np.zeros(3)
        normal[axis] = sign
        a = np.roll(normal, 1)
        b = np.cross(normal, a)
        start = len(vertices)
        for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            vertices.append((normal + s * a + t * b) * half + (0, 0, half[2]))
            normals.append(normal)
            uv.append(((k + 0.5 + 0.3 * s) / 6, 0.5 + 0.3 * t))
        faces += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    return _mesh(vertices, normals, uv, faces, texture)


def cone(radius_m: float, height_m: float, texture: Texture, sides: int = 12) -> TexturedMesh:
    """Return a cone with smooth normals that stands on z = 0."""
    vertices, normals, uv, faces = [], [], [], []
    slope = radius_m / height_m
    for k in range(sides):
        corners = []
        for n, radius, z in ((k, radius_m, 0.0), (k + 1, radius_m, 0.0), (k + 0.5, 0.0, height_m)):
            angle = 2 * np.pi * n / sides
            corners.append((radius * np.cos(angle), radius * np.sin(angle), z))
            normal = np.array([np.cos(angle), np.sin(angle), slope])
            normals.append(normal / np.linalg.norm(normal))
            uv.append((0.45, 0.5))
        vertices += corners
        faces.append((3 * k, 3 * k + 1, 3 * k + 2))
    return _mesh(vertices, normals, uv, faces, texture)


def ground(extent_m: float, texture: Texture, cells: int = 1) -> TexturedMesh:
    """Return a flat square about the origin; the texture's top is at +y."""
    steps = np.linspace(0.0, 1.0, cells + 1)
    u, v = (g.ravel() for g in np.meshgrid(steps, steps))
    vertices = np.column_stack([(u - 0.5) * extent_m, (0.5 - v) * extent_m, np.zeros_like(u)])
    row, column = (g.ravel() for g in np.mgrid[:cells, :cells])
    a = row * (cells + 1) + column
    b, c, d = a + 1, a + cells + 1, a + cells + 2
    faces = np.concatenate([np.column_stack([a, c, d]), np.column_stack([a, d, b])])
    return _mesh(vertices, np.tile([0.0, 0.0, 1.0], (len(u), 1)), np.column_stack([u, v]), faces, texture)


def _mesh(vertices: object, normals: object, uv: object, faces: object, texture: Texture) -> TexturedMesh:
    return TexturedMesh(
        np.asarray(vertices, np.float32),
        np.asarray(normals, np.float32),
        np.asarray(uv, np.float32),
        np.asarray(faces, np.int32),
        texture,
    )


def palette(rng: np.random.Generator, low: int = 40, high: int = 230) -> Texture:
    """Return six random colours, 8 texels wide each."""
    return Texture(np.repeat(rng.integers(low, high, (1, 6, 3), dtype=np.uint8), 8, axis=1).repeat(8, axis=0))


def ground_texture(rng: np.random.Generator, size: int) -> Texture:
    """Return streets, fields and grain, ``size`` texels square."""
    picture = np.full((size, size, 3), (86, 118, 60), np.float32)
    cells = rng.integers(-18, 18, (size // 64, size // 64, 3)).repeat(64, 0).repeat(64, 1)
    picture += cells
    for k in range(0, size, size // 8):
        width = size // 60
        picture[k : k + width] = picture[:, k : k + width] = (98, 98, 102)
    for k in range(0, size, size // 8):
        middle = k + size // 120
        picture[middle : middle + 2] = picture[:, middle : middle + 2] = (230, 230, 225)
    picture += rng.integers(-9, 10, (size, size, 1))
    return Texture(np.clip(picture, 0, 255).astype(np.uint8), smooth=True)


def pose(x: float, y: float, yaw_rad: float = 0.0, z: float = 0.0) -> NDArray[np.float64]:
    """Return T_world_body of a body turned about the vertical."""
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw_rad), -np.sin(yaw_rad)], [np.sin(yaw_rad), np.cos(yaw_rad)]]
    T[:3, 3] = (x, y, z)
    return T


def build_town(
    rng: np.random.Generator,
    *,
    extent_m: float = 400.0,
    texels: int = 1024,
    houses: int = 40,
    cars: int = 12,
    trees: int = 30,
) -> World:
    """Return a town of boxes; cars are movable and come last."""
    world = World()
    world.add(ground(extent_m, ground_texture(rng, texels), 4), np.eye(4), name="ground", category="ground")

    def place() -> tuple[float, float, float]:
        x, y = rng.uniform(-0.45 * extent_m, 0.45 * extent_m, 2)
        return float(x), float(y), float(rng.uniform(0, 2 * np.pi))

    for k in range(houses):
        size = tuple(float(s) for s in rng.uniform((8, 6, 4), (16, 12, 12)))
        world.add(box(size, palette(rng)), pose(*place()), name=f"house-{k}", category="building")
    green = [palette(rng, 40, 110) for _ in range(3)]
    for k in range(trees):
        mesh = cone(float(rng.uniform(1.5, 3.5)), float(rng.uniform(5, 10)), green[k % 3])
        world.add(mesh, pose(*place()), name=f"tree-{k}", category="tree")
    for k in range(cars):
        mesh = box((4.4, 1.8, 1.5), palette(rng))
        world.add(mesh, pose(*place()), name=f"car-{k}", category="vehicle", movable=True)
    return world
