"""A world of which bodies were removed, and others added, is packed and drawn like a new one."""

from __future__ import annotations

import gc
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


def fixed_world() -> World:
    world = World()
    add(world, FIXED, movable=False)
    return world


@pytest.mark.parametrize("renderer", ["raster", "pybullet"])
def test_a_copy_with_bodies_of_its_own_is_drawn_like_a_new_world(renderer: str) -> None:
    original = fixed_world()
    copies = []
    for movers in (FEW, MORE, FEW, (), MORE):
        copies.append(original.copy())
        add(copies[-1], movers, movable=True)
    drawn = [create_renderer(renderer, copy) for copy in copies]
    # All are open at the same time.
    pictures = [each.gbuffer(CAMERA, VIEW) for each in drawn]
    for movers, copy, first, each in zip((FEW, MORE, FEW, (), MORE), copies, pictures, drawn, strict=True):
        new = fixed_world()
        add(new, movers, movable=True)
        expected = create_renderer(renderer, new).gbuffer(CAMERA, VIEW)
        for picture in (first, each.gbuffer(CAMERA, VIEW)):
            for ours, theirs in zip(picture, expected, strict=True):
                np.testing.assert_array_equal(ours, theirs)
        assert (first.instance_id >= len(FIXED)).any() == bool(movers)
        for ours, theirs in zip(pack_scene(copy)[0], pack_scene(new)[0], strict=True):
            np.testing.assert_array_equal(ours, theirs)
            assert ours.dtype == theirs.dtype


def test_what_copies_share_is_packed_once_and_held_once(monkeypatch: pytest.MonkeyPatch) -> None:
    packed: list[int] = []
    world = fixed_world()
    shapes = pack_shapes(world)
    assert pack_shapes(world) is shapes
    texels = pack_scene(world)[1].texels
    write = textures._write_mip_chain
    monkeypatch.setattr(
        textures, "_write_mip_chain", lambda texture, *rest: packed.append(id(texture)) or write(texture, *rest)
    )
    for _ in range(2):
        copy = world.copy()
        add(copy, FEW, movable=True)
        assert np.shares_memory(pack_scene(copy)[1].texels, texels)
    assert packed == [id(FEW[0].texture)]


def test_textures_that_are_gone_make_room_for_others() -> None:
    world = fixed_world()
    sizes = set()
    for k in range(20):
        copy = world.copy()
        # A cone has a palette of its own: as many texels as every other's.
        add(copy, (cone(1.0, 2.0, noisy(8, k), 7),), movable=True)
        sizes.add(len(pack_scene(copy)[1].texels))
        del copy
        gc.collect()
    assert len(sizes) <= 2
