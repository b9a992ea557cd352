"""What a first look at the pictures must not find: torn bricks, shadows apart from their feet."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from scenarios.catalog import scenario
from scenarios.stereo_follow.building import draw_building
from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.lighting import set_light
from scenarios.stereo_follow.panels import Panel
from sim.render.raster import Raster
from sim.shaders.baked.shader import BakedLightShader

SEED = 4
"""People in the sunny yard."""


def _bricks_per_m(piece: Panel) -> np.ndarray:
    """Return the texture's widths and heights in a metre of a panel (2,)."""
    left, low, right, high = piece.window
    return np.array([right - left, high - low]) / [np.linalg.norm(piece.side_a_m), np.linalg.norm(piece.side_b_m)]


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["facade", "hall front wall", "hall back wall", "corridor front wall"])
def test_the_pieces_of_a_wall_show_one_texture_that_runs_on_over_their_seams(name):
    for seed in range(4):
        plan = draw_floor_plan(np.random.default_rng(seed))
        pieces = [p for p in draw_building(plan, np.random.default_rng(seed)).panels if p.name == name]
        assert len(pieces) == 3
        assert len({id(piece.texture) for piece in pieces}) == 1
        # Where the texture's lower left corner would lie, seen from each piece.
        origins_m = [
            piece.corner_m
            - piece.window[0] / _bricks_per_m(piece)[0] * piece.side_a_m / np.linalg.norm(piece.side_a_m)
            - piece.window[1] / _bricks_per_m(piece)[1] * piece.side_b_m / np.linalg.norm(piece.side_b_m)
            for piece in pieces
        ]
        for piece, origin_m in zip(pieces, origins_m, strict=True):
            np.testing.assert_allclose(_bricks_per_m(piece), _bricks_per_m(pieces[0]), rtol=1e-9)
            np.testing.assert_allclose(origin_m, origins_m[0], atol=1e-9)


@pytest.mark.heavy
def test_shadows_begin_at_the_shoes():
    """Beside the feet, the floor is darker than with raised panels, on which shadows begin some way off."""
    episode = scenario("stereo-follow").episode("quick", SEED)
    frame, world, light = episode.step(), episode.world, episode._shader
    raised = BakedLightShader(world, light._baked)
    set_light(raised, episode.plan.light, 0)
    camera, T_world_camera = frame.camera, frame.truth.T_world_camera
    gbuffer = Raster(world).gbuffer(camera, T_world_camera)
    lux, raised_lux = (shader.shade(gbuffer, camera, T_world_camera)[:, 1] for shader in (light, raised))
    names = np.array([*(body.name for body in world.bodies), "sky"])[gbuffer.instance_id]
    episode.close()
    feet = np.char.endswith(names.astype(str), "foot").astype(np.uint8)
    beside = (cv2.dilate(feet, np.ones((7, 7), np.uint8)) > 0) & (names == "paving")
    apart = cv2.dilate(feet, np.ones((99, 99), np.uint8)) == 0
    assert feet.sum() > 100
    assert (lux[beside] < 0.7 * raised_lux[beside]).mean() > 0.1
    assert (np.abs(lux[apart] / np.maximum(raised_lux[apart], 1e-9) - 1.0) < 0.01).mean() > 0.9
