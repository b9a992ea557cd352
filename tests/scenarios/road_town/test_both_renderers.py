"""The two G-buffers of a road town, pixel for pixel, by the rule of ``tests/sim/render/test_pybullet_renderer``."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.catalog import scenario
from sim.render.protocol import create_renderer
from sim.render.visibility import NEAR_M
from tests.sim.ray_casting import away_from_edges
from trackers.types import CameraModel


@pytest.fixture(scope="module", params=["quick", "bridges[width_px=320,height_px=240]"])
def views(request):
    episode = scenario("road-town").episode(request.param, 3)
    poses = [episode.step().truth.T_world_camera for _ in range(120)]
    yield episode.world, poses[5::38]
    episode.close()


@pytest.mark.heavy
@pytest.mark.parametrize("pixel_offset", [0.0, 0.5])
def test_both_renderers_see_the_same_town(views, pixel_offset):
    world, poses = views
    camera = CameraModel.from_field_of_view(320, 240, np.radians(50))
    differing, off_colour = [], []
    for T_world_camera in poses:
        raster, reference = (
            create_renderer(name, world).gbuffer(camera, T_world_camera, pixel_offset=pixel_offset)
            for name in ("raster", "pybullet")
        )
        differs = raster.instance_id != reference.instance_id
        differing.append(differs.mean())
        assert not (differs & away_from_edges(raster.instance_id)).any()
        error_m = np.abs(raster.depth_m - reference.depth_m)[~differs]
        # Within a body one surface may hide another at an edge: eaves over a wall, a car's roof over its bonnet.
        assert (error_m < 12 * raster.depth_m[~differs] ** 2 / NEAR_M * 2.0**-24 + 1e-3).mean() > 0.999
        palettes = ~differs & np.array([not body.mesh.texture.smooth for body in world.bodies])[raster.instance_id]
        off_colour.append((raster.base_colour_rgb != reference.base_colour_rgb).any(axis=-1)[palettes].mean())
        ground = ~differs & ~palettes
        means = [gbuffer.base_colour_rgb[ground].mean(axis=0) for gbuffer in (raster, reference)]
        np.testing.assert_allclose(*means, atol=1.0)
    assert np.mean(differing) <= 1e-4
    # Fine patterns (tiles, windows): a point on the border of two texels falls on either side by rounding.
    assert np.mean(off_colour) <= 0.005
