"""Bullet's rays against our visibility: random pixels and random places on bodies, in a few frames of each scene."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from scenarios import catalog
from sim import bullet
from sim.optics import project, rays
from sim.render.protocol import create_renderer
from sim.world import World
from tests.scenarios.standing_in_one_another import pairs_in_one_another
from tests.sim.ray_casting import away_from_edges
from tests.sim.squares import block

SCENES = ("road-town", "stereo-follow", "fish-tank", "harbour")
FRAMES, PIXELS, PLACES = (0, 40), 300, 300


@pytest.mark.heavy
@pytest.mark.parametrize("name", SCENES)
def test_rays_agree_with_what_is_visible_and_what_is_hidden(name: str) -> None:
    pytest.importorskip("pybullet")
    scene = catalog.scenario(name)
    preset = replace(scene.presets["quick"], width_px=160, height_px=120)
    episode: Any = scene.episode(preset, 3, closed_loop=False)
    rng = np.random.default_rng(4)
    world, renderer, camera = episode.world, create_renderer("raster", episode.world), episode._camera.model
    with bullet.client(world, exact=True) as client:
        index_of = {handle: index for index, handle in enumerate(client.handles)}
        for frame in FRAMES:
            episode._move_to(frame)
            client.push()
            T_world_camera = episode._T_world_camera
            seen = renderer.gbuffer(camera, T_world_camera)
            eye_m = T_world_camera[:3, 3]
            clear = away_from_edges(seen.instance_id, 2) & np.isfinite(seen.depth_m)
            rows, columns = np.nonzero(clear)
            some = rng.choice(len(rows), min(PIXELS, len(rows)), replace=False)
            rows, columns = rows[some], columns[some]
            along = rays(camera, T_world_camera, np.column_stack([columns, rows]) + 0.5)
            far_m = eye_m + along * (seen.depth_m[rows, columns, None] * 1.05 + 0.5)
            hits = client.engine.rayTestBatch(np.tile(eye_m, (len(rows), 1)).tolist(), far_m.tolist())
            same = [index_of.get(hit[0], -1) for hit in hits] == seen.instance_id[rows, columns]
            assert same.mean() > 0.99
            # Places on the moving bodies, seen or hidden by other bodies.
            movers = [body for body in world.bodies if body.movable and body.category not in ("sea", "rope")]
            places_m = []
            for body in rng.choice(np.array(movers, dtype=object), PLACES):
                T, point_m = world.poses[body.index], rng.choice(body.mesh.vertices_m)
                places_m.append(T[:3, :3] @ point_m + T[:3, 3])
            pixels, depth_m = project(camera, T_world_camera, np.array(places_m))
            inside = ((pixels >= 2) & (pixels < (camera.width_px - 2, camera.height_px - 2))).all(axis=1)
            column, row = pixels[inside].astype(int).T
            depth_m, places = depth_m[inside], np.array(places_m)[inside]
            margin_m = 0.02 * depth_m + 0.1
            ahead_m = seen.depth_m[row, column]
            hidden, plain = ahead_m < depth_m - margin_m, clear[row, column]
            hits = client.engine.rayTestBatch(np.tile(eye_m, (len(places), 1)).tolist(), places.tolist())
            blocked = np.array([hit[2] for hit in hits]) * depth_m < depth_m - margin_m
            assert plain.sum() == 0 or (hidden == blocked)[plain].mean() > 0.97


def test_things_that_stand_in_one_another_are_counted_and_neighbours_are_not() -> None:
    pytest.importorskip("pybullet")
    world = World()
    for name, x_m in (("a 0", 0.0), ("a 1", 0.4), ("b 0", 1.9), ("c 0", 2.91)):
        T = np.eye(4)
        T[0, 3] = x_m
        world.add(block((1, 1, 1)), T, name=name, category="vehicle", movable=True)
    with bullet.client(world) as client:
        assert pairs_in_one_another(client, world) == {}
        T[0, 3] = 1.2
        world.move(world.bodies[2], T)
        assert pairs_in_one_another(client, world) == {("a", "b"): pytest.approx(0.2, abs=0.01)}
