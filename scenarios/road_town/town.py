"""First, plain version, so that episodes can be lived through; the town helper replaces it."""

from __future__ import annotations

import cv2
import numpy as np


def build_town(layout, rng):
    from sim.world import World
    from sim.mesh import Texture
    from sim.meshes.ground import ground
    from sim.meshes.house import house
    from sim.meshes.tree import tree

    N = 4096
    e = layout.extent_m
    px = lambda p: np.stack([(p[:, 0] + e / 2), (e / 2 - p[:, 1])], 1) * N / e * 16
    img = np.empty((N, N, 3), np.uint8)
    img[:] = (88, 112, 62)
    img = np.clip(
        img
        + cv2.resize(rng.normal(0, 9, (512, 512, 1)).astype(np.float32), (N, N))[..., None]
        + rng.normal(0, 7, (N, N, 1)),
        0,
        255,
    ).astype(np.uint8)

    def line(p, w, c):
        cv2.polylines(img, [px(p).round().astype(np.int32)], False, c, max(1, int(w * N / e)), cv2.LINE_AA, 4)

    for s in layout.graph.streets:
        line(s.centre_m, s.width_m + 3, (165, 160, 150))
    mask = np.zeros((N, N), np.uint8)
    for s in layout.graph.streets:
        line(s.centre_m, s.width_m, (92, 92, 95))
        cv2.polylines(
            mask, [px(s.centre_m).round().astype(np.int32)], False, 255, int(s.width_m * N / e), cv2.LINE_8, 4
        )
    for s in layout.graph.streets:
        t = np.gradient(s.centre_m, axis=0)
        t /= np.linalg.norm(t, axis=1, keepdims=True)
        n = np.stack([-t[:, 1], t[:, 0]], 1)
        k = 8
        for sd in (-1, 1):
            line((s.centre_m + sd * n * (s.width_m / 2 - 0.35))[k:-k], 0.18, (225, 225, 225))
        for i in range(k, len(s.centre_m) - k - 3, 6):
            line(s.centre_m[i : i + 4], 0.15, (225, 225, 225))
    w = World()
    w.add(ground(e, Texture(img, True)), np.eye(4), name="ground", category="ground")

    def P(c, y):
        T = np.eye(4)
        T[:2, :2] = [[np.cos(y), -np.sin(y)], [np.sin(y), np.cos(y)]]
        T[:2, 3] = c
        return T

    for i, b in enumerate(layout.buildings):
        w.add(
            house(b.size_m, b.roof, b.wall_rgb, b.roof_rgb, rng),
            P(b.centre_m, b.yaw_rad),
            name=f"h{i}",
            category="building",
        )
    for i, b in enumerate(layout.trees):
        w.add(tree(b.radius_m, b.height_m, rng), P(b.centre_m, 0), name=f"t{i}", category="tree")
    return w


def add_vehicle(world, name, model, paint):
    from sim.meshes.vehicle import vehicle

    return world.add(vehicle(model, paint), np.eye(4), name=name, category="vehicle", movable=True)
