"""A world of which bodies were removed, and others added, is packed and drawn like a new one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from sim.mesh import Texture, TexturedMesh
from sim.optics import look_down_pose
from sim.render import textures
from sim.render.protocol import create_renderer
from sim.render.scene import pack_scene, pack_shapes
from sim.world import World
from tests.sim.demo_scene import box, cone, ground, pose
from trackers.types import CameraModel

CAMERA = CameraModel(60, 40, 50.0)
VIEW = look_down_pose(np.array([0.0, -1.0, 20.0]), 0.3, 0.1, -0.1)


def noisy(side_px: int, seed: int) -> Texture:
    return Texture(np.random.default_rng(seed).integers(0, 256, (side_px, side_px, 3), np.uint8), smooth=True)


FIXED = (ground(20.0, noisy(33, 0)), box((2.0, 1.0, 3.0), noisy(16, 1)))
FEW = (cone(1.0, 2.0, noisy(8, 3), 7),)
MORE = (box((1.0, 4.0, 1.0), noisy(64, 2)), cone(2.0, 1.0, noisy(8, 4), 9), FIXED[1])


def add(world: World, meshes: Sequence[TexturedMesh], movable: bool) -> None:
    for k, mesh in enumerate(meshes):
        world.add(mesh, pose(2.0 * k - 2.0, k, 0.4 * k), name=str(k), category="thing", movable=movable)


@pytest.mark.parametrize("renderer", ["raster", "pybullet"])
def test_a_world_with_other_bodies_is_drawn_like_a_new_one(renderer: str) -> None:
    kept = World()
    add(kept, FIXED, movable=False)
    for movers in (FEW, MORE, FEW, (), MORE):
        kept.remove_after(len(FIXED))
        add(kept, movers, movable=True)
        new = World()
        add(new, FIXED, movable=False)
        add(new, movers, movable=True)
        pictures = [create_renderer(renderer, world).gbuffer(CAMERA, VIEW) for world in (kept, new)]
        for ours, theirs in zip(*pictures, strict=True):
            np.testing.assert_array_equal(ours, theirs)
        if renderer == "raster":
            for ours, theirs in zip(pack_scene(kept), pack_scene(new), strict=True):
                for part, other in zip(ours, theirs, strict=True):
                    np.testing.assert_array_equal(part, other)
                    assert part.dtype == other.dtype
        assert (pictures[0].instance_id >= len(FIXED)).any() == bool(movers)


def test_what_remains_is_not_packed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    packed: list[int] = []
    world = World()
    add(world, FIXED, movable=False)
    add(world, MORE, movable=True)
    shapes = pack_shapes(world)
    assert pack_shapes(world) is shapes
    pack_scene(world)
    write = textures._write_mip_chain
    monkeypatch.setattr(
        textures, "_write_mip_chain", lambda texture, *rest: packed.append(id(texture)) or write(texture, *rest)
    )
    world.remove_after(len(FIXED))
    add(world, FEW, movable=True)
    pack_scene(world)
    assert packed == [id(FEW[0].texture)]


def test_a_removed_body_is_gone_and_indices_go_on_from_the_others() -> None:
    world = World()
    add(world, FIXED, movable=False)
    add(world, MORE, movable=True)
    world.move_all(world.bodies[2:], np.tile(np.eye(4), (3, 1, 1)))
    world.remove_after(len(FIXED))
    assert world.poses.shape == (2, 4, 4)
    add(world, FEW, movable=True)
    assert [body.index for body in world.bodies] == [0, 1, 2]
    np.testing.assert_array_equal(world.poses[2], pose(-2.0, 0.0))
