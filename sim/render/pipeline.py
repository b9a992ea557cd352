"""From world to finished picture: renderer, shader and sensor in one call.

The stages are those of ``Renderer.gbuffer``, ``Shader.shade`` and ``CameraSensor.expose``, with the same kernels.
``raster`` takes each row through all of them while it is in the processor's nearest memory, and the stages' whole
pictures are never written; only where lens or motion bring light from one pixel to its neighbours does the sensor wait
for the whole radiance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Protocol, TypeGuard

import numpy as np
from numba import njit
from numba.extending import overload
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import PinholeCamera
from sim.render.attributes import RowRoom, resolve_row
from sim.render.compilation import NO_COUNTING, announce_compilation, row_kernel
from sim.render.protocol import Renderer
from sim.render.raster import Raster
from sim.render.row_buffers import WorkRoom, work_room
from sim.render.textures import TexturePool
from sim.render.visibility import TriangleTable
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import Picture, SensorSettings
from sim.sensors.exposure import METER_STEP_PX, metered_radiance
from sim.sensors.motion_blur import needs_blur
from sim.sensors.noise import NO_DEVELOPMENT, DarkRoom, Development, develop_row, develop_rows
from sim.shaders.baked.shader_kernels import BakedArrays, baked_row
from sim.shaders.daylight import DaylightArrays, ShadowArrays
from sim.shaders.daylight_kernels import shade_row


class Shader(Protocol):
    """Lights what is seen of one world."""

    def shade(
        self, gbuffer: GBuffer, camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B."""
        ...


class RowShader(Shader, Protocol):
    """One whose light a row kernel reads: ``DaylightShader`` and ``BakedLightShader``."""

    def row_light(
        self, depth_m: NDArray[np.float32], camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> tuple[DaylightArrays | BakedArrays, ShadowArrays]:
        """Return the light of the world as it is now, as the kernel reads it that belongs to the first one's type.

        Args:
            depth_m: (H, W).
        """
        ...


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
    shader: Shader,
    sensor: CameraSensor,
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    frame: int,
    *,
    motion: NDArray[np.float64] | None = None,
    interval_s: float = 1.0,
    settings: SensorSettings | None = None,
) -> Capture:
    """Draw, light and photograph the world as it is now; the sensor's loops take one step.

    Arguments as for ``CameraSensor.expose``.

    Args:
        settings: to take the picture with, and the sensor's loops stay as they are: how the second camera of a stereo
            pair follows the first one's.
    """
    if isinstance(renderer, Raster) and _lights_rows(shader):
        return _capture_by_rows(renderer, shader, sensor, camera, T_world_camera, frame, motion, interval_s, settings)
    gbuffer = renderer.gbuffer(camera, T_world_camera)
    radiance = shader.shade(gbuffer, camera, T_world_camera)
    picture = _photograph(sensor, radiance, camera, frame, motion, interval_s, settings)
    return Capture(picture, gbuffer.depth_m, gbuffer.instance_id)


def _lights_rows(shader: Shader) -> TypeGuard[RowShader]:
    # Asked of every picture: a protocol that is checked at run time takes a hundred times as long.
    return hasattr(shader, "row_light")


def _photograph(
    sensor: CameraSensor,
    radiance: NDArray[np.float32],
    camera: PinholeCamera,
    frame: int,
    motion: NDArray[np.float64] | None,
    interval_s: float,
    given: SensorSettings | None,
) -> Picture:
    if given is None:
        return sensor.expose(radiance, camera, frame, motion=motion, interval_s=interval_s)
    return sensor.develop(radiance, camera, frame, given, motion=motion, interval_s=interval_s)


def _capture_by_rows(
    renderer: Raster,
    shader: RowShader,
    sensor: CameraSensor,
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    frame: int,
    motion: NDArray[np.float64] | None,
    interval_s: float,
    given: SensorSettings | None,
) -> Capture:
    nearness, triangle = renderer.visible(camera, T_world_camera)
    height, width = nearness.shape
    depth_m, instance_id = np.empty((height, width), np.float32), np.empty((height, width), np.int32)
    with np.errstate(divide="ignore"):
        np.divide(np.float32(1.0), nearness, out=depth_m)
    light, shadows = shader.row_light(depth_m, camera, T_world_camera)
    settings = sensor.settings if given is None else given
    announce_compilation(_finish_rows)

    def finish(rows: NDArray[np.int64], film: NDArray[np.float32], development: Development) -> None:
        _finish_rows(
            renderer.textures,
            renderer.table,
            nearness,
            triangle,
            light,
            shadows,
            rows,
            development,
            depth_m,
            instance_id,
            film,
            work,
        )

    work = work_room(width)
    if settings is None or _moves_light(camera, settings, motion, interval_s):
        film = sensor.film(height, width)
        finish(np.arange(height), film, NO_DEVELOPMENT)
        picture = _photograph(sensor, film, camera, frame, motion, interval_s, given)
        return Capture(picture, depth_m, instance_id)
    # The rows that the light meter looks at come first: what of their light is scattered falls on all the others too.
    metered_rows, other_rows = _metered_and_other_rows(height)
    film = sensor.film(len(metered_rows), width)
    finish(metered_rows, film, NO_DEVELOPMENT)
    metered = metered_radiance(film, row_step=1)
    image_rgb = np.empty((height, width, 3), np.uint8)
    development = sensor.development(metered, settings, frame, image_rgb)
    develop_rows(film, metered_rows, development)
    finish(other_rows, film[:1], development)
    if given is None:
        sensor.step(metered)
    return Capture(Picture(image_rgb, settings), depth_m, instance_id)


@cache
def _metered_and_other_rows(height: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows of a picture that the light meter looks at, and all others; nobody writes to them."""
    is_metered = np.arange(height) % METER_STEP_PX == 0
    return np.flatnonzero(is_metered), np.flatnonzero(~is_metered)


def _moves_light(
    camera: PinholeCamera, settings: SensorSettings, motion: NDArray[np.float64] | None, interval_s: float
) -> bool:
    """Return whether lens or motion bring light from one pixel to others, so that rows need each other."""
    if camera.radial_distortion != (0.0, 0.0):
        return True
    share = settings.exposure_s / interval_s
    return motion is not None and needs_blur(camera.width_px, camera.height_px, motion, share)


def _light_row(light, shadows, row, colour, depth_m, instance_id, normal, room, at, bench, radiance):
    """Stands for the row kernel that belongs to the type of ``light``: the compiler puts that one here."""
    raise NotImplementedError


@overload(_light_row, jit_options=NO_COUNTING)
def _row_kernel(light, shadows, row, colour, depth_m, instance_id, normal, room, at, bench, radiance):
    def by_day(light, shadows, row, colour, depth_m, instance_id, normal, room, at, bench, radiance):
        shade_row(light, shadows, row, colour, depth_m, normal, room, at, radiance)

    def baked(light, shadows, row, colour, depth_m, instance_id, normal, room, at, bench, radiance):
        baked_row(light, shadows, row, colour, depth_m, instance_id, normal, room, at, bench, radiance)

    return by_day if light.instance_class is DaylightArrays else baked


@njit(cache=True)
def _finish_rows(
    textures: TexturePool,
    table: TriangleTable,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    light: DaylightArrays | BakedArrays,
    shadows: ShadowArrays,
    rows: NDArray[np.int64],
    development: Development,
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    radiance: NDArray[np.float32],
    work: WorkRoom,
) -> None:
    """Write depth, ids and radiance of the given rows (R,), and their pictures if the development has one.

    Args:
        depth_m, instance_id: (H, W).
        radiance: (R, 3, W); or (1, 3, W), room for a row of it on its way to the picture.
    """
    _finish_each(
        textures,
        table,
        nearness,
        triangle,
        light,
        shadows,
        rows,
        development,
        depth_m,
        instance_id,
        radiance,
        work.row,
        work.dark,
        work.colour,
        work.room,
        work.at,
        work.bench,
    )


@row_kernel()
def _finish_each(
    textures: TexturePool,
    table: TriangleTable,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    light: DaylightArrays | BakedArrays,
    shadows: ShadowArrays,
    rows: NDArray[np.int64],
    development: Development,
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    radiance: NDArray[np.float32],
    row_room: RowRoom,
    dark_room: DarkRoom,
    colour: NDArray[np.uint32],
    room: NDArray[np.float32],
    at: NDArray[np.uint32],
    bench: NDArray[np.float32],
) -> None:
    """``_finish_rows`` by a kernel that counts nobody who holds arrays."""
    for k in range(rows.shape[0]):
        row = rows[k]
        depth, identity = depth_m[row], instance_id[row]
        resolve_row(textures, table, row, nearness[row], triangle[row], row_room, colour, depth, identity)
        light_out = radiance[k % radiance.shape[0]]
        _light_row(light, shadows, row, colour, depth, identity, row_room.normal, room, at, bench, light_out)
        if development.image_rgb.shape[0] > 0:
            develop_row(light_out, development, row, dark_room)
