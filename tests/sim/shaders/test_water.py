"""Light in and on water, and the panels that it mirrors."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from sim.optics import project
from sim.render.pipeline import capture
from sim.render.protocol import create_renderer
from sim.render.refraction import ThroughWater
from sim.render.water.rays import STEP_PX
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.caustics import FloorLight, LightThroughSurface
from sim.shaders.water import Panel, Water, WaterShader, _spread
from tests.sim.water_scene import FLOOR, HIGH_M, LEVEL_M, LOW_M, WALLS, looking, surface, tank

STRAIGHT_DOWN = LightThroughSurface(100.0, np.zeros(2), np.zeros(2))
LAMP = Panel((-0.2, 0.3, 1.5), (0.06, 0.0, 0.0), (0.0, 0.06, 0.0), 60_000.0)


def _radiance(water, content=None, panels=(LAMP,), angle_deg=0, balls_m=(), ambient_lx=150.0):
    camera, T_world_camera = looking(angle_deg)
    world = tank(balls_m, 0.012)
    seen = ThroughWater(create_renderer("raster", world), water).gbuffer(camera, T_world_camera)
    shader = WaterShader(world, water, content or Water(), panels, ambient_lx)
    return shader.shade(seen, camera, T_world_camera), seen


def _is_bright(radiance, seen):
    """Return where the water over the floor shines as the floor does not."""
    return (radiance[:, 1] > 2.0 * np.median(radiance[:, 1])) & (seen.instance_id == FLOOR)


def _inside(light, margin_m=0.03):
    extent, shape = light.extent(), light.maps().shape[1:]
    x = extent.first_m[0] + extent.step_m * np.arange(shape[1])
    y = extent.first_m[1] + extent.step_m * np.arange(shape[0])
    return np.ix_(
        (y > LOW_M[1] + margin_m) & (y < HIGH_M[1] - margin_m), (x > LOW_M[0] + margin_m) & (x < HIGH_M[0] - margin_m)
    )


def _counted(water, rays, rng):
    """Return how many of many vertical rays, bent by Snell's law, reach each cell of 2 cm, relative to their mean."""
    low, high = np.array(LOW_M) - 0.03, np.array(HIGH_M) + 0.03
    places = rng.uniform(low, high, (rays, 2))
    height, slope_x, slope_y = water.height_and_slope(places).T
    normal = np.column_stack([-slope_x, -slope_y, np.ones(rays)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    incoming = np.array([0.0, 0.0, -1.0])
    # Snell for the part along the surface; the part across it follows from the unit length.
    along = (incoming - (normal @ incoming)[:, None] * normal) / water.refractive_index
    bent = along - np.sqrt(1 - (along**2).sum(axis=1))[:, None] * normal
    landed = places + bent[:, :2] / -bent[:, 2:] * (LEVEL_M + height)[:, None]
    edges = [np.arange(LOW_M[k] + 0.03, HIGH_M[k] - 0.03 + 1e-9, 0.02) for k in (1, 0)]
    counts = np.histogram2d(landed[:, 1], landed[:, 0], edges)[0]
    return counts / (rays / np.prod(high - low) * 0.02**2), edges


@pytest.mark.heavy
def test_caustics_are_those_of_rays_drawn_at_random():
    water = surface(0.06)
    world = tank()
    light = FloorLight(world, water, [STRAIGHT_DOWN])
    caustic = light.maps()[1].copy()
    extent = light.extent()
    counts, edges = _counted(water, 400_000, np.random.default_rng(0))
    rows, columns = (
        (np.add.outer(edge[:-1], np.linspace(0.001, 0.019, 10)) - first) / extent.step_m
        for edge, first in zip(edges, extent.first_m[::-1], strict=True)
    )
    sampled = cv2.remap(
        caustic, *(part.astype(np.float32) for part in np.meshgrid(columns.ravel(), rows.ravel())), cv2.INTER_LINEAR
    )
    mean = sampled.reshape(len(edges[0]) - 1, 10, len(edges[1]) - 1, 10).mean(axis=(1, 3))
    assert counts.std() > 0.12
    # 460 rays fall on a cell: 5 % of chance.
    assert np.corrcoef(mean.ravel(), counts.ravel())[0, 1] > 0.93
    assert np.abs(mean - counts).mean() < 0.06


@pytest.mark.parametrize("slope_rms", [0.0, 0.02, 0.08])
def test_caustics_neither_add_nor_take_light(slope_rms):
    world = tank()
    light = FloorLight(world, surface(slope_rms), [STRAIGHT_DOWN])
    caustic = light.maps()[1][_inside(light, 0.0)]
    assert caustic.mean() == pytest.approx(1.0, abs=0.01)
    assert caustic.std() < 0.02 if slope_rms == 0.0 else caustic.std() > 2.0 * slope_rms


def test_caustics_wander_and_wide_lamps_have_none():
    wide = LightThroughSurface(100.0, np.zeros(2), np.array([0.4, 0.4]))
    world = tank()
    water = surface()
    sharp, blurred = (FloorLight(world, water, [light]) for light in (STRAIGHT_DOWN, wide))
    first = sharp.maps()[1].copy()
    assert blurred.maps()[1].std() < 0.1 * first.std()
    water.time_s += 0.5
    assert np.corrcoef(first.ravel(), sharp.maps()[1].ravel())[0, 1] < 0.6


def test_a_shadow_takes_the_light_that_falls_on_the_body_and_lies_down_the_light():
    place_m, run, size_m = np.array([0.05, -0.04, 0.06]), np.array([0.3, -0.2]), 0.008
    water = surface(0.0)
    world = tank([place_m], size_m)
    light = FloorLight(world, water, [LightThroughSurface(1.0, run, np.array([0.15, 0.15]))])
    with_shadow, without = light.maps()
    taken = (without - with_shadow).astype(float)
    extent = light.extent()
    rows, columns = np.mgrid[: taken.shape[0], : taken.shape[1]]
    middle = extent.first_m + extent.step_m * np.array([(taken * columns).sum(), (taken * rows).sum()]) / taken.sum()
    np.testing.assert_allclose(middle, place_m[:2] + run * place_m[2], atol=5e-4)
    # A body counts as the ellipsoid that fills its bounds; the light sees that of a cube as a longer ellipse.
    silhouette_m2 = 0.25 * np.pi * size_m**2 * np.hypot(1.0, np.hypot(*run))
    assert taken.sum() * extent.step_m**2 == pytest.approx(silhouette_m2, rel=0.05)


def test_clear_flat_water_lets_the_floor_be_seen_dimmed_by_its_index():
    content = Water(0.0, (0.0, 0.0, 0.0), floor_reflectance=0.0)
    radiance, seen = _radiance(surface(0.0), content, panels=(), ambient_lx=1000.0)
    rho = ((seen.base_colour_rgb[240, 320, 1] / 255 + 0.055) / 1.055) ** 2.4
    reflected = (0.333 / 2.333) ** 2
    expected = (1 - reflected) / 1.333**2 * rho * 930.0 / np.pi + reflected * 1000.0 / np.pi
    assert seen.instance_id[240, 320] == FLOOR
    assert radiance[240, 1, 320] == pytest.approx(expected, rel=0.03)


def test_murky_water_veils_what_is_deep():
    balls_m = np.array([[-0.1, 0.0, 0.10], [0.0, 0.0, 0.06], [0.1, 0.0, 0.02]])
    contrasts = {}
    for scattering_per_m in (0.2, 10.0):
        radiance, seen = _radiance(surface(0.0), Water(scattering_per_m), balls_m=balls_m)
        floor = radiance[:, 1][seen.instance_id == FLOOR].mean()
        balls = [radiance[:, 1][seen.instance_id == WALLS + 1 + k].mean() for k in range(3)]
        contrasts[scattering_per_m] = 1.0 - np.array(balls) / floor
    assert (contrasts[0.2] > 0.7).all()
    assert (np.diff(contrasts[10.0]) < -0.05).all()
    assert contrasts[10.0][2] < 0.6 * contrasts[0.2][2]


def test_absorption_takes_red_first():
    clear, _ = _radiance(surface(0.0), Water(0.0, (0.0, 0.0, 0.0)))
    tinted, _ = _radiance(surface(0.0), Water(0.0, (6.0, 1.0, 0.0)))
    left = tinted[240, :, 320] / clear[240, :, 320]
    assert left[0] < 0.6 * left[1] < left[2]
    assert left[2] == pytest.approx(1.0, abs=1e-3)


def test_flat_water_mirrors_a_panel_where_the_law_of_reflection_says():
    panel = Panel((0.05, 0.1, 1.5), (0.2, 0.0, 0.0), (0.0, 0.1, 0.0), 5000.0)
    water, (camera, T_world_camera) = surface(0.0), looking(0)
    lit, seen = _radiance(water, panels=(panel,))
    rows, columns = np.nonzero(_is_bright(lit, seen))
    beneath_m = np.array([[*panel.middle_m[:2], 2 * LEVEL_M - panel.middle_m[2]]])
    middle = project(camera, T_world_camera, beneath_m)[0][0]
    np.testing.assert_allclose([columns.mean() + 0.5, rows.mean() + 0.5], middle, atol=1.5)
    side_px = camera.focal_px * 0.2 / (T_world_camera[2, 3] - beneath_m[0, 2])
    assert sorted([np.ptp(columns), np.ptp(rows)]) == pytest.approx([0.5 * side_px, side_px], abs=8)
    # Two hundredths of its luminance, at normal incidence.
    added = lit[round(middle[1]), 1, round(middle[0])] - np.median(lit[:, 1])
    assert added == pytest.approx((0.333 / 2.333) ** 2 * 5000.0, rel=0.1)


def test_a_window_has_bars_and_ripples_break_it():
    window = Panel((0.05, 0.1, 1.5), (0.3, 0.0, 0.0), (0.0, 0.3, 0.0), 5000.0, 6500.0, (2, 2), 0.15)
    whole, barred = (
        _is_bright(*_radiance(surface(0.0), panels=(panel,)))
        for panel in (
            Panel(*(getattr(window, name) for name in ("middle_m", "side_a_m", "side_b_m", "luminance_nit"))),
            window,
        )
    )
    assert 0.5 < barred.sum() / whole.sum() < 0.9
    broken = _is_bright(*_radiance(surface(0.04), panels=(window,)))
    count = [cv2.connectedComponents(bright.astype(np.uint8))[0] for bright in (barred, broken)]
    assert count[0] == 5
    assert count[1] > 6


def test_fused_pictures_are_those_of_the_stages():
    water, (camera, T_world_camera) = surface(), looking(30)
    balls_m = np.array([[0.0, 0.0, 0.05], [0.1, 0.1, 0.02]])
    world = tank(balls_m, 0.02)
    parts = [
        (
            ThroughWater(create_renderer("raster", world), water),
            WaterShader(world, water, Water(3.0), [LAMP], 100.0),
            CameraSensor(SensorConfig(longest_exposure_s=0.02), np.random.default_rng(2)),
        )
        for _ in range(2)
    ]
    for frame in range(3):
        water.time_s = frame / 30.0
        fused = capture(*parts[0], camera, T_world_camera, frame)
        renderer, shader, sensor = parts[1]
        seen = renderer.gbuffer(camera, T_world_camera)
        picture = sensor.expose(shader.shade(seen, camera, T_world_camera), camera, frame)
        np.testing.assert_array_equal(fused.instance_id, seen.instance_id)
        np.testing.assert_array_equal(fused.depth_m, seen.depth_m)
        difference = np.abs(fused.picture.image_rgb.astype(int) - picture.image_rgb)
        assert (difference > 1).mean() < 1e-3


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Water(-1.0), "scattering_per_m: expected a number in"),
        (lambda: Water(absorption_per_m=(1.0, -1.0, 0.0)), "absorption_per_m: expected three numbers in"),
        (lambda: Water(particles_rgb=(2.0, 1.0, 1.0)), "particles_rgb: expected three numbers in"),
        (lambda: Panel((0, 0, 1), (1, 0, 0), (1, 0, 0), 1.0), "side_a_m, side_b_m: expected sides of a rectangle"),
        (lambda: Panel((0, 0, 1), (1, 0, 0), (0, 1, 0), -1.0), "luminance_nit: expected a number in"),
        (lambda: Panel((0, 0, 1), (1, 0, 0), (0, 1, 0), 1.0, panes=(0, 1)), "panes: expected two numbers >= 1"),
        (
            lambda: _radiance(surface(), panels=[Panel((0, 0, 0.1), (1, 0, 0), (0, 1, 0), 1.0)]),
            "panels: expected above",
        ),
        (lambda: _radiance(surface(), ambient_lx=-1.0), "ambient_lx: expected a number >= 0"),
    ],
)
def test_impossible_light_is_named(build, message):
    with pytest.raises(ValueError, match=message):
        build()


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


SPOT = Panel((0.05, 0.1, 1.5), (0.06, 0.0, 0.0), (0.0, 0.06, 0.0), 400_000.0)


def _mirrored(slope_rms, smooth_glare):
    """Return what is seen of a bright lamp alone, the mean of R, G and B (H, W)."""
    camera, T_world_camera = looking(0)
    water, world = surface(slope_rms), tank()
    seen = ThroughWater(create_renderer("raster", world), water).gbuffer(camera, T_world_camera)
    shader = WaterShader(world, water, Water(), (SPOT,), 150.0, smooth_glare=smooth_glare)
    whole = shader.shade(seen, camera, T_world_camera).mean(axis=1)
    shader._panels.nit[:] = 0.0
    return whole - shader.shade(seen, camera, T_world_camera).mean(axis=1)


@pytest.mark.parametrize("slope_rms", [0.003, 0.03])
def test_smooth_glare_has_no_stairs_and_the_same_light(slope_rms):
    """A camera that is blinded fifty times over sees an edge of at least two steps in place of one."""
    sharp, smooth = (_mirrored(slope_rms, each) for each in (False, True))
    assert smooth.sum() == pytest.approx(sharp.sum(), rel=0.12)
    white = 0.02 * sharp.max()
    steps = {}
    for name, image in (("sharp", sharp), ("smooth", smooth)):
        shown = np.clip(image / white, 0.0, 1.0)
        across = np.abs(np.diff(shown, axis=1))
        steps[name] = np.percentile(across[across > 0.3], 50)
        assert (across > 0.3).sum() > 10
    assert steps["sharp"] > 0.9
    assert steps["smooth"] < 0.75
    # Far from every edge both see the lamp, or nothing.
    inside = ndimage.minimum_filter(sharp, 9) > 0.98 * sharp.max()
    np.testing.assert_allclose(smooth[inside], sharp[inside], rtol=0.05)
    outside = ndimage.maximum_filter(sharp, 31) == 0.0
    assert smooth[outside].max() < 0.05 * white


@given(change=st.floats(1e-3, 30.0), start=st.floats(-1.0, 1.0))
@settings(max_examples=60, deadline=None)
def test_a_bar_gives_as_much_light_as_it_is_wide_however_few_pixels_it_takes(change, start):
    """The sum over pixels of what is seen of a length of 1 is the number of pixels that it spans."""
    reach = int(0.5 / change + 40.0)
    places = np.float32(start * change) + np.arange(-reach, reach + 1, dtype=np.float32) * np.float32(change)
    seen = sum(float(_spread(place, np.float32(change))) for place in places)
    assert seen == pytest.approx(1.0 / change, rel=0.04, abs=1e-3)
