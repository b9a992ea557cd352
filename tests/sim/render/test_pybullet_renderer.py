"""The two renderers draw one world to one G-buffer.

What may differ, and why. Both sample each pixel at one point, so that point may fall on either side of an edge by
rounding alone: ids may differ only in pixels that touch another body, and in at most 1 in 1,000 of all. Away from such
edges depth agrees to the precision of PyBullet's 32-bit depth buffer. PyBullet takes the nearest texel of the full
texture where raster interpolates between texels or in a mip level: colours of palettes agree exactly, those of smooth
textures only on average. Normals from depth agree away from edges and creases.
"""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import PinholeCamera, look_down_pose
from sim.render.protocol import create_renderer
from sim.render.visibility import NEAR_M
from sim.world import World
from tests.sim.demo_scene import box, ground, ground_texture, palette
from tests.sim.ray_casting import away_from_edges

CAMERA = PinholeCamera.from_field_of_view(320, 240, np.radians(55))
VIEWS = {
    "down": (np.array([5.0, 8.0, 60.0]), 0.3, 0.0, 0.0),
    "tilted": (np.array([-30.0, 10.0, 45.0]), 2.0, 0.5, -0.3),
    "horizon": (np.array([0.0, -20.0, 20.0]), 4.0, 1.3, 0.1),
}


def _both(world, view, pixel_offset):
    T_world_camera = look_down_pose(*VIEWS[view])
    return (
        create_renderer(name, world).gbuffer(CAMERA, T_world_camera, pixel_offset=pixel_offset)
        for name in ("raster", "pybullet")
    )


@pytest.mark.heavy
@pytest.mark.parametrize("pixel_offset", [0.0, 0.5])
@pytest.mark.parametrize("view", VIEWS)
def test_both_renderers_see_the_same(town, view, pixel_offset):
    raster, reference = _both(town, view, pixel_offset)
    differs = raster.instance_id != reference.instance_id
    assert differs.mean() <= 1e-3
    clear = away_from_edges(raster.instance_id)
    assert not (differs & clear).any()

    seen = ~differs & (raster.instance_id >= 0)
    # Half a step of the depth buffer is worth depth² / near 2^-25; TinyRenderer's own sums lose some more.
    step_m = raster.depth_m[seen] ** 2 / NEAR_M * 2.0**-24
    error_m = np.abs(raster.depth_m[seen] - reference.depth_m[seen])
    assert (error_m <= 12 * step_m + 1e-3).mean() > 0.9999
    assert np.median(error_m) < 5e-3

    palettes = seen & (raster.instance_id > 0)
    same_colour = (raster.base_colour_rgb == reference.base_colour_rgb).all(axis=-1)
    # A body's faces differ in colour, and their common edges are edges too.
    assert same_colour[palettes].mean() > 0.995
    soil = clear & (raster.instance_id == 0)
    means = [gbuffer.base_colour_rgb[soil].mean(axis=0) for gbuffer in (raster, reference)]
    np.testing.assert_allclose(*means, atol=0.5)


def test_normals_from_depth_are_those_of_the_faces(town):
    raster, reference = _both(town, "tilted", 0.5)
    clear = away_from_edges(raster.instance_id, 2)
    cosine = np.einsum("ijk,ijk->ij", raster.normal_world, reference.normal_world)
    flat = clear & (raster.instance_id < 31)  # ground and boxes
    assert np.percentile(cosine[flat], 1) > np.cos(np.radians(8.0))
    assert (cosine[flat] > np.cos(np.radians(3.0))).mean() > 0.98
    lengths = np.linalg.norm(reference.normal_world[reference.instance_id >= 0], axis=-1)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-5)


def test_an_enlarged_texture_has_its_texels_at_the_same_places():
    texture = ground_texture(np.random.default_rng(1), 64)
    T_world_camera = look_down_pose(np.array([0, 0, 12.0]), 0.4, 0.0, 0.0)
    world = World()
    world.add(ground(40.0, texture), np.eye(4), name="plane", category="ground")
    smooth, nearest = (
        create_renderer(name, world).gbuffer(CAMERA, T_world_camera).base_colour_rgb.astype(int)
        for name in ("raster", "pybullet")
    )
    # At the middle of a texel both show that texel: the interpolated picture crosses each of its values.
    flat = (np.abs(np.diff(nearest, axis=1, prepend=-1)).sum(-1) == 0) & (smooth == nearest).all(-1)
    assert flat.mean() > 0.02
    assert np.abs((smooth - nearest).mean(axis=(0, 1))).max() < 0.3


def test_unlit_colours_do_not_depend_on_the_direction_of_faces():
    texture = palette(np.random.default_rng(0))
    world = World()
    world.add(box((4, 4, 4), texture), np.eye(4), name="box", category="building")
    side_on = look_down_pose(np.array([-6, -6, 7.0]), np.pi / 4, 0.9, 0.0)
    gbuffer = create_renderer("pybullet", world).gbuffer(CAMERA, side_on)
    colours = np.unique(gbuffer.base_colour_rgb[gbuffer.instance_id == 0], axis=0)
    assert {tuple(colour) for colour in colours} <= {tuple(colour) for colour in texture.rgb[0]}
    assert len(colours) >= 3


def test_unknown_renderer_is_named():
    world = World()
    with pytest.raises(ValueError, match="renderer: expected one of raster, pybullet, got 'gl'"):
        create_renderer("gl", world)
