"""Spans of mirrored panels against the places of all pixels."""

from __future__ import annotations

import numpy as np
import pytest

from sim.render.water.rays import STEP_PX
from sim.shaders.water import Panel, Water, WaterShader
from tests.sim.water_scene import looking, surface, tank

TUBE = Panel((0.0, 0.0, 2.6), (0.0, 1.2, 0.0), (0.02, 0.0, 0.0), 5000.0)
WINDOW = Panel((0.3, 0.2, 2.6), (0.7, 0.0, 0.0), (0.0, 0.9, 0.0), 2000.0)


def _at_pixels(nodes, row, columns):
    """Return the values of one row of pixels, interpolated between nodes (R, C)."""
    above, share = divmod(row, STEP_PX)
    line = nodes[above] + share / STEP_PX * (nodes[above + 1] - nodes[above])
    return np.interp(columns, STEP_PX * np.arange(nodes.shape[1]), line)


@pytest.mark.parametrize("time_s", [0.0, 1.3])
def test_spans_have_all_columns_that_show_a_panel_and_leave_others_out(time_s):
    camera, T_world_camera = looking(20)
    water = surface()
    water.time_s = time_s
    world = tank()
    shader = WaterShader(world, water, Water(), (TUBE, WINDOW), 100.0)
    light = shader.row_light(np.ones((camera.height_px, camera.width_px), np.float32), camera, T_world_camera)
    columns = np.arange(camera.width_px)
    shown, in_span = np.zeros(2, int), np.zeros(2, int)
    for panel in range(2):
        for row in range(camera.height_px):
            along = [_at_pixels(light.places[panel, k], row, columns) for k in (0, 1)]
            on_panel = columns[np.abs(along).max(axis=0) < 0.5]
            first, behind = light.spans[panel, row // STEP_PX]
            assert ((on_panel >= first) & (on_panel < behind)).all()
            shown[panel] += len(on_panel)
            in_span[panel] += max(0, min(behind, camera.width_px) - first)
    assert (shown > 100).all()
    assert in_span.min() < 0.5 * camera.width_px * camera.height_px
