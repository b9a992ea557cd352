"""A shader and a sensor of one band that the fast path does not know, registered nowhere, and its imports."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import sim.render
from sim.gbuffer import SKY
from sim.optics import PinholeCamera, look_down_pose
from sim.render import row_stages
from sim.render.compilation import row_kernel
from sim.render.pipeline import capture
from sim.render.raster import Raster
from sim.render.row_stages import RowStage, light_picture
from sim.shaders.daylight import shade_row

CAMERA = PinholeCamera.from_field_of_view(160, 120, np.radians(55))
POSE = look_down_pose(np.array([2.0, 8.0, 60.0]), 0.3, 0.05, 0.3)
SKY_K = np.float32(250.0)


class Temperatures(NamedTuple):
    """Of bodies (B,) float32, in kelvin."""

    body_k: NDArray[np.float32]


class Counts(NamedTuple):
    """Where counts (H, W) uint16 are written, and how many there are to a kelvin."""

    per_k: np.float32
    counts: NDArray[np.uint16]


class Doubled(NamedTuple):
    """Scratch: (W,) float32."""

    line: NDArray[np.float32]


@row_kernel()
def warm_row(light, row, surfaces, scratch, radiance):
    """Write each body's temperature."""
    for k in range(radiance.shape[1]):
        body = surfaces.instance_id[k]
        radiance[0, k] = SKY_K if body == SKY else light.body_k[body]


@row_kernel()
def count_row(development, row, scratch, radiance):
    """Write counts."""
    for k in range(radiance.shape[1]):
        scratch.line[k] = radiance[0, k] * development.per_k
        development.counts[row, k] = np.uint16(scratch.line[k])


class Warmth:
    """Shader of one band."""

    lighting = RowStage(warm_row, lambda width: None, channels=1)

    def __init__(self, bodies: int) -> None:
        self._body_k = np.linspace(280.0, 310.0, bodies).astype(np.float32)

    def row_light(self, depth_m, camera, T_world_camera):
        """See ``RowShader``."""
        return Temperatures(self._body_k)

    def shade(self, gbuffer, camera, T_world_camera):
        """See ``Shader``."""
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)


class Counter:
    """Sensor of one band whose pictures are counts; with gain control only where ``whole``."""

    developing = RowStage(count_row, lambda width: Doubled(np.empty(width, np.float32)))
    metered_row_step = 7

    def __init__(self, *, whole: bool = False) -> None:
        self.whole = whole
        self.seen: list[tuple[int, ...]] = []

    def film(self, rows, width):
        """See ``RowSensor``."""
        return np.empty((rows, 1, width), np.float32)

    def needs_whole(self, camera, settings, motion):
        """See ``RowSensor``."""
        return self.whole

    def expose(self, radiance, camera, frame, **exposing):
        """Spread the temperatures of the picture over 14 bits."""
        self.seen.append(radiance.shape)
        low, high = radiance.min(), radiance.max()
        return ((radiance[:, 0] - low) * np.float32(16383 / (high - low))).astype(np.uint16)

    def develop(self, radiance, camera, frame, settings, **exposing):
        """Count."""
        return (radiance[:, 0] * np.float32(settings)).astype(np.uint16)

    def develop_first(self, radiance, rows, camera, frame, settings):
        """See ``RowSensor``."""
        self.seen.append(radiance.shape)
        counts = np.zeros((camera.height_px, camera.width_px), np.uint16)
        counts[rows] = self.develop(radiance, camera, frame, settings)
        return counts, Counts(np.float32(settings), counts)


@pytest.mark.heavy
def test_one_band_goes_through_the_fast_path(town):
    renderer, shader, sensor = Raster(town), Warmth(len(town.bodies)), Counter()
    seen = capture(renderer, shader, sensor, CAMERA, POSE, 0, settings=50.0)
    gbuffer = renderer.gbuffer(CAMERA, POSE)
    radiance = shader.shade(gbuffer, CAMERA, POSE)
    assert radiance.shape == (120, 1, 160)
    assert sensor.seen == [(18, 1, 160)]  # Only the metered rows of it were ever there.
    np.testing.assert_array_equal(seen.instance_id, gbuffer.instance_id)
    np.testing.assert_array_equal(seen.picture, sensor.develop(radiance, CAMERA, 0, 50.0))
    assert len(np.unique(seen.picture)) == len(np.unique(seen.instance_id))


def test_a_sensor_that_needs_the_whole_picture_gets_it(town):
    renderer, shader, sensor = Raster(town), Warmth(len(town.bodies)), Counter(whole=True)
    seen = capture(renderer, shader, sensor, CAMERA, POSE, 0)
    assert sensor.seen == [(120, 1, 160)]
    assert seen.picture.min() == 0
    assert seen.picture.max() > 16000
    whole = shader.shade(renderer.gbuffer(CAMERA, POSE), CAMERA, POSE)
    np.testing.assert_array_equal(seen.picture, sensor.expose(whole, CAMERA, 0))


def test_the_compiled_form_of_each_shader_is_kept_apart():
    day, warm = (row_stages._compiled(row_stages._picture_lighting, kernel) for kernel in (shade_row, warm_row))
    assert Path(day.stats.cache_path) == Path(warm.stats.cache_path)
    assert warm_row.py_func.__module__ in warm.py_func.__qualname__
    assert warm.py_func.__qualname__ != day.py_func.__qualname__


def test_a_compiled_form_is_found_again_on_disk(town):
    """As in another process: numba has forgotten the function, and makes it anew."""
    shader, gbuffer = Warmth(len(town.bodies)), Raster(town).gbuffer(CAMERA, POSE)
    once = shader.shade(gbuffer, CAMERA, POSE)
    row_stages._compiled.cache_clear()
    np.testing.assert_array_equal(once, shader.shade(gbuffer, CAMERA, POSE))
    again = row_stages._compiled(row_stages._picture_lighting, warm_row)
    assert (again.stats.cache_hits.total(), again.stats.cache_misses.total()) == (1, 0)


def test_rendering_imports_no_shader_and_no_sensor():
    for source in Path(sim.render.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(source.read_text())):
            if isinstance(node, ast.ImportFrom):
                assert not (node.module or "").startswith(("sim.shaders", "sim.sensors")), source.name
