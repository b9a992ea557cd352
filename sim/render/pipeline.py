"""From world to finished picture: renderer, shader and sensor in one call.

The stages are those of ``Renderer.gbuffer``, ``DaylightShader.shade`` and ``CameraSensor.expose``, with the same
kernels. ``raster`` takes each row through all of them while it is in the processor's nearest memory, and the stages'
whole pictures are never written; only where lens or motion bring light from one pixel to others does the sensor wait
for the whole radiance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import PinholeCamera
from sim.render.attributes import new_row_room, resolve_row
from sim.render.compilation import announce_compilation
from sim.render.protocol import Renderer
from sim.render.raster import Raster
from sim.render.textures import TexturePool
from sim.render.visibility import TriangleTable
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import Picture, SensorSettings
from sim.sensors.exposure import METER_STEP_PX
from sim.sensors.motion_blur import needs_blur
from sim.sensors.noise import develop_row
from sim.shaders.daylight import PROBE_STEP_PX, DaylightArrays, DaylightShader, ShadowArrays
from sim.shaders.daylight_kernels import shade_row

_NO_SETTINGS_YET = SensorSettings(1.0, 1.0)
"""Stands in for settings where none are known yet and nothing is exposed."""


@dataclass(frozen=True, slots=True)
class Capture:
    """A finished picture and what is seen in it; see ``GBuffer`` for the two maps.

    Attributes:
        depth_m: (H, W) float32.
        instance_id: (H, W) int32.
    """

    picture: Picture
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]


def capture(
    renderer: Renderer,
    shader: DaylightShader,
    sensor: CameraSensor,
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    frame: int,
    *,
    motion: NDArray[np.float64] | None = None,
    interval_s: float = 1.0,
) -> Capture:
    """Draw, light and photograph the world as it is now; the sensor's loops take one step.

    Arguments as for ``CameraSensor.expose``.
    """
    if isinstance(renderer, Raster):
        return _capture_by_rows(renderer, shader, sensor, camera, T_world_camera, frame, motion, interval_s)
    gbuffer = renderer.gbuffer(camera, T_world_camera)
    radiance = shader.shade(gbuffer, camera, T_world_camera)
    picture = sensor.expose(radiance, camera, frame, motion=motion, interval_s=interval_s)
    return Capture(picture, gbuffer.depth_m, gbuffer.instance_id)


def _capture_by_rows(
    renderer: Raster,
    shader: DaylightShader,
    sensor: CameraSensor,
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    frame: int,
    motion: NDArray[np.float64] | None,
    interval_s: float,
) -> Capture:
    nearness, triangle = renderer.visible(camera, T_world_camera)
    with np.errstate(divide="ignore"):
        probe_depth_m = 1.0 / nearness[::PROBE_STEP_PX, ::PROBE_STEP_PX]
    shadows = shader.shadows(probe_depth_m, camera, T_world_camera)
    shape = nearness.shape
    depth_m, instance_id = np.empty(shape, np.float32), np.empty(shape, np.int32)
    settings = sensor.settings
    scatters = sensor.config.veiling_glare > 0
    whole = settings is None or scatters or _moves_light(camera, settings, motion, interval_s)
    radiance = np.empty((shape[0] if whole else 1, 3, shape[1]), np.float32)
    image_rgb = np.empty((0 if whole else shape[0], shape[1], 3), np.uint8)
    announce_compilation(_finish_rows)
    metered = _finish_rows(
        renderer.textures,
        renderer.table,
        nearness,
        triangle,
        shader.light,
        shadows,
        sensor.response(settings or _NO_SETTINGS_YET),
        sensor.frame_keys(frame),
        depth_m,
        instance_id,
        radiance,
        image_rgb,
    )
    if settings is None or whole:
        picture = sensor.expose(radiance, camera, frame, motion=motion, interval_s=interval_s)
        return Capture(picture, depth_m, instance_id)
    sensor.step(metered)
    return Capture(Picture(image_rgb, settings), depth_m, instance_id)


def _moves_light(
    camera: PinholeCamera, settings: SensorSettings, motion: NDArray[np.float64] | None, interval_s: float
) -> bool:
    """Return whether lens or motion bring light from one pixel to others, so that rows need each other."""
    if camera.radial_distortion != (0.0, 0.0):
        return True
    share = settings.exposure_s / interval_s
    return motion is not None and needs_blur(camera.width_px, camera.height_px, motion, share)


@njit(cache=True)
def _finish_rows(
    textures: TexturePool,
    table: TriangleTable,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    light: DaylightArrays,
    shadows: ShadowArrays,
    response: NDArray[np.float32],
    keys: NDArray[np.uint32],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    radiance: NDArray[np.float32],
    image_rgb: NDArray[np.uint8],
) -> NDArray[np.float64]:
    """Write the last four arrays row by row; return the light meter's mean radiance (3,).

    Args:
        radiance: (H, 3, W), and nothing goes on to the sensor; or (1, 3, W), room for a row of it on its way to the
            picture.
        image_rgb: (0, W, 3) or (H, W, 3) accordingly.
    """
    height, width = triangle.shape
    room, at = np.empty((8, width), np.float32), np.empty((2, width), np.uint32)
    row_room, colour = new_row_room(width), np.empty(width, np.uint32)
    normal = np.empty((3, width), np.float32)
    values = np.empty((3, width), np.uint16)
    metered = np.zeros(3)
    count = 0
    for row in range(height):
        depth, identity = depth_m[row], instance_id[row]
        resolve_row(textures, table, row, nearness[row], triangle[row], row_room, colour, depth, identity, normal)
        light_out = radiance[row % radiance.shape[0]]
        shade_row(light, shadows, row, colour, depth, normal, room, at, light_out)
        if image_rgb.shape[0] > 0:
            develop_row(light_out, response, keys, row, values, room, image_rgb[row])
        if row % METER_STEP_PX == 0:
            for column in range(0, width, METER_STEP_PX):
                count += 1
                for channel in range(3):
                    metered[channel] += light_out[channel, column]
    return metered / count
