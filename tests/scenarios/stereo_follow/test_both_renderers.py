"""The two G-buffers of a building with people, by the rule of ``tests/sim/render/test_pybullet_renderer``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.catalog import scenario
from scenarios.scenario import Frame, RendererName
from sim.gbuffer import SKY
from sim.render.protocol import create_renderer
from sim.render.visibility import NEAR_M
from tests.scenarios.stereo_follow.conftest import Recorded
from tests.sim.ray_casting import away_from_edges


@pytest.mark.heavy
@pytest.mark.parametrize("pixel_offset", [0.0, 0.5])
def test_both_renderers_see_the_same_people_in_the_same_building(recorded: Recorded, pixel_offset: float):
    episode = recorded.episode
    differing, off_colour = [], []
    for frame in recorded.frames[8::24]:
        episode._objects.move_to(frame.truth.frame)
        for pose in (frame.truth.T_world_camera, frame.truth.T_world_right):
            raster, reference = (
                create_renderer(name, episode.world).gbuffer(frame.camera, pose, pixel_offset=pixel_offset)
                for name in ("raster", "pybullet")
            )
            differs = raster.instance_id != reference.instance_id
            differing.append(differs.mean())
            assert not (differs & away_from_edges(raster.instance_id)).any()
            assert len(np.unique(raster.instance_id)) > 20
            solid = ~differs & (raster.instance_id != SKY)
            error_m = np.abs(raster.depth_m[solid] - reference.depth_m[solid])
            # Within a body one surface may hide another at an edge.
            allowed_m = 12 * raster.depth_m[solid] ** 2 / NEAR_M * 2.0**-24 + 1e-3
            assert (error_m < allowed_m).mean() > 0.999
            colour_rgb, reference_rgb = raster.base_colour_rgb.astype(float), reference.base_colour_rgb.astype(float)
            for body in map(episode.world.bodies.__getitem__, np.unique(raster.instance_id[solid])):
                of_body = solid & (raster.instance_id == body.index)
                # A smooth texture's nearest texels are those of the average on average; others are nearest in both.
                if body.mesh.texture.smooth and of_body.sum() > 1000:
                    ours, theirs = (each[of_body].mean(axis=0) for each in (colour_rgb, reference_rgb))
                    np.testing.assert_allclose(ours, theirs, atol=6.0, err_msg=body.name)
                elif not body.mesh.texture.smooth:
                    off_colour.append((colour_rgb != reference_rgb).any(axis=-1)[of_body].mean())
    assert np.mean(differing) <= 1e-4
    assert np.mean(off_colour) <= 0.005


@pytest.mark.heavy
@pytest.mark.parametrize("preset", ["quick", "varied", "outdoors"])
def test_an_episode_is_the_same_to_look_at_by_either(preset: str):
    first, frame = (_first_frame(preset, renderer) for renderer in ("raster", "pybullet"))
    ours, theirs = (each.observation.image_rgb.astype(int) for each in (first, frame))
    difference = np.abs(theirs - ours).max(axis=-1)
    # PyBullet shows the nearest texel: equal pictures would both be of one renderer.
    assert difference.any()
    differs = frame.truth.instance_map != first.truth.instance_map
    assert differs.mean() <= 1e-3
    clear = away_from_edges(first.truth.instance_map)
    assert not (differs & clear).any()
    solid = clear & np.isfinite(first.truth.depth_m)
    np.testing.assert_allclose(frame.truth.depth_m[solid], first.truth.depth_m[solid], rtol=0.02)
    # Nearest texels make 4.8 % of pixels differ by more than 8; a shift by a pixel 7.4 %, a light 5 % brighter 7.6 %.
    assert np.abs((theirs - ours)[clear].mean(axis=0)).max() < 0.5
    assert (difference[clear] > 8).mean() < 0.06
    assert frame.truth.visible_fraction == pytest.approx(first.truth.visible_fraction, abs=0.005)
    assert frame.truth.place == first.truth.place


def _first_frame(preset: str, renderer: RendererName) -> Frame:
    scene = scenario("stereo-follow-v2")
    small = replace(scene.presets[preset], width_px=320, height_px=240)
    episode = scene.episode(small, 3, renderer=renderer)
    frame = episode.step()
    episode.close()
    return frame
