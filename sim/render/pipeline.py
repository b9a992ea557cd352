"""From world to finished picture: renderer, shader and sensor in one call.

The stages are those of ``Renderer.gbuffer``, ``Shader.shade`` and ``Sensor.expose``, with the same kernels. With
a ``RowRenderer`` and a ``RowShader``, and where it can be a ``RowSensor``, each row passes through all stages while it
is in the processor's cache, and the stages' whole pictures are never written, but the radiance for a sensor that needs
all of it first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, Generic, NamedTuple, Protocol, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import Camera, CameraMotion
from sim.render.protocol import Renderer
from sim.render.row_stages import RowStage, finish_rows, finish_smooth_rows

_Picture = TypeVar("_Picture", covariant=True)


class RowRenderer(Renderer, Protocol):
    """A renderer that finishes its pictures row by row.

    Attributes:
        resolving: its stage.
    """

    resolving: RowStage

    def visible(self, camera: Camera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5) -> Any:
        """Return a NamedTuple that the stage's kernel reads; arguments as for ``gbuffer``.

        It has ``depth_m`` (H, W) float32, and ``instance_id`` (H, W) int32, which the kernel writes.
        """
        ...


class Shader(Protocol):
    """Lights views of one world."""

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, C, W) float32: of R, G and B in cd/m², or of one band."""
        ...


class RowShader(Shader, Protocol):
    """A shader that lights row by row.

    Attributes:
        lighting: its stage.
    """

    lighting: RowStage

    def row_light(self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]) -> Any:
        """Return the light of the world as it is now, a NamedTuple that the stage's kernel reads.

        Args:
            depth_m: (H, W).
        """
        ...


class Sensor(Protocol[_Picture]):
    """Makes pictures of radiance with as many channels as the shader's."""

    def expose(
        self, radiance: NDArray[np.float32], camera: Camera, frame: int, motion: CameraMotion | None = None
    ) -> _Picture:
        """Take the picture of a frame, then let the sensor's loops take one step.

        Args:
            radiance: (H, C, W) float32.
            camera: that takes the picture.
            frame: index, >= 0; with the pixel it determines the noise.
            motion: None for a camera at rest.
        """
        ...

    def develop(
        self,
        radiance: NDArray[np.float32],
        camera: Camera,
        frame: int,
        settings: Any,
        motion: CameraMotion | None = None,
    ) -> _Picture:
        """Take a picture with given settings; the loops stay as they are. Arguments as for ``expose``."""
        ...


class RowSensor(Sensor[_Picture], Protocol[_Picture]):
    """A sensor that develops row by row.

    Attributes:
        developing: its stage.
        metered_row_step: distance of the rows that are lit first, for ``develop_first``.
    """

    developing: RowStage
    metered_row_step: int

    def film(self, rows: int, width: int) -> NDArray[np.float32]:
        """Return scratch for a radiance (rows, C, width)."""
        ...

    def needs_whole(self, camera: Camera, settings: Any, motion: CameraMotion | None) -> bool:
        """Return whether no row of the next picture can be developed before all are lit."""
        ...

    def develop_first(
        self, radiance: NDArray[np.float32], rows: NDArray[np.int64], camera: Camera, frame: int, settings: Any
    ) -> tuple[_Picture, Any]:
        """Begin a picture by its metered rows, of radiance (R, C, W).

        Args:
            rows: numbers of those that are developed now, (R,) or none.
            settings: None for the sensor's own, whose loops then take one step.

        Returns:
            the picture with the developed rows, and the NamedTuple with which the stage's kernel adds the others.
        """
        ...


@dataclass(frozen=True, slots=True)
class Capture(Generic[_Picture]):
    """A finished picture and its visible surfaces; see ``GBuffer`` for the two maps.

    Attributes:
        depth_m: (H, W) float32.
        instance_id: (H, W) int32.
    """

    picture: _Picture
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]


def capture(
    renderer: Renderer,
    shader: Shader,
    sensor: Sensor[_Picture],
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    frame: int,
    *,
    motion: CameraMotion | None = None,
    settings: Any = None,
    smooth: bool = False,
) -> Capture[_Picture]:
    """Draw, light and photograph the world as it is now; the sensor's loops take one step.

    Arguments as for ``Sensor.expose``.

    Args:
        settings: of the picture, with which the sensor's loops stay as they are: for the second camera of a stereo
            pair.
        smooth: whether edges are without stairs, see ``sim.render.smooth_edges``; those of PyBullet's renderer, which
            tells no triangles, keep them. Light is measured before edges are smoothed, or after it where the whole
            picture is lit first.
    """
    shot = _Shot(camera, T_world_camera, frame, settings, motion, smooth)
    if _draws_rows(renderer) and _lights_rows(shader):
        return _capture_by_rows(renderer, shader, sensor, shot)
    gbuffer = renderer.gbuffer(camera, T_world_camera)
    picture = _photograph(sensor, shader.shade(gbuffer, camera, T_world_camera), shot)
    return Capture(picture, gbuffer.depth_m, gbuffer.instance_id)


class _Shot(NamedTuple):
    """How one picture is taken: the arguments of ``capture``."""

    camera: Camera
    T_world_camera: NDArray[np.float64]
    frame: int
    settings: Any
    motion: CameraMotion | None
    smooth: bool


def radiance_of(
    renderer: Renderer, shader: Shader, camera: Camera, T_world_camera: NDArray[np.float64], *, smooth: bool
) -> NDArray[np.float32]:
    """Return the radiance (H, C, W) of the world as it is now; arguments as for ``capture``."""
    if _draws_rows(renderer) and _lights_rows(shader):
        film = np.empty((camera.height_px, shader.lighting.channels, camera.width_px), np.float32)
        seen = renderer.visible(camera, T_world_camera)
        _light_all(renderer, seen, shader, shader.row_light(seen.depth_m, camera, T_world_camera), film, smooth)
        return film
    return shader.shade(renderer.gbuffer(camera, T_world_camera), camera, T_world_camera)


def _light_all(
    renderer: RowRenderer, seen: Any, shader: RowShader, light: Any, film: NDArray[np.float32], smooth: bool
) -> None:
    if smooth:
        finish_smooth_rows(renderer.resolving, seen, film[:0], 1, shader.lighting, light, film)
    else:
        finish_rows(renderer.resolving, seen, np.arange(len(film)), shader.lighting, light, film)


# Checking the protocol at run time, for every picture, would take a hundred times as long.
def _draws_rows(renderer: Renderer) -> TypeGuard[RowRenderer]:
    return getattr(renderer, "resolving", None) is not None


def _lights_rows(shader: Shader) -> TypeGuard[RowShader]:
    return hasattr(shader, "lighting")


def _develops_rows(sensor: Sensor[_Picture]) -> TypeGuard[RowSensor[_Picture]]:
    return hasattr(sensor, "developing")


def _photograph(sensor: Sensor[_Picture], radiance: NDArray[np.float32], shot: _Shot) -> _Picture:
    if shot.settings is None:
        return sensor.expose(radiance, shot.camera, shot.frame, motion=shot.motion)
    return sensor.develop(radiance, shot.camera, shot.frame, shot.settings, motion=shot.motion)


def _capture_by_rows(
    renderer: RowRenderer, shader: RowShader, sensor: Sensor[_Picture], shot: _Shot
) -> Capture[_Picture]:
    camera, resolving, lighting = shot.camera, renderer.resolving, shader.lighting
    seen = renderer.visible(camera, shot.T_world_camera)
    height, width = seen.depth_m.shape
    light = shader.row_light(seen.depth_m, camera, shot.T_world_camera)
    if not _develops_rows(sensor) or sensor.needs_whole(camera, shot.settings, shot.motion):
        shape = height, lighting.channels, width
        film = sensor.film(height, width) if _develops_rows(sensor) else np.empty(shape, np.float32)
        _light_all(renderer, seen, shader, light, film, shot.smooth)
        return Capture(_photograph(sensor, film, shot), seen.depth_m, seen.instance_id)
    # The metered rows come first: their scattered light falls on all others.
    metered_rows, other_rows = _metered_and_other_rows(height, sensor.metered_row_step)
    film = sensor.film(len(metered_rows), width)
    finish_rows(resolving, seen, metered_rows, lighting, light, film)
    # Where edges are smoothed no row is developed yet: each waits for the next.
    begun = metered_rows[:0] if shot.smooth else metered_rows
    picture, development = sensor.develop_first(film, begun, camera, shot.frame, shot.settings)
    if shot.smooth:
        step, two_rows = sensor.metered_row_step, np.empty((2, lighting.channels, width), np.float32)
        finish_smooth_rows(resolving, seen, film, step, lighting, light, two_rows, sensor.developing, development)
    else:
        finish_rows(resolving, seen, other_rows, lighting, light, film[:1], sensor.developing, development)
    return Capture(picture, seen.depth_m, seen.instance_id)


@cache
def _metered_and_other_rows(height: int, step: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the metered rows of a picture, and all others; read only."""
    is_metered = np.arange(height) % step == 0
    return np.flatnonzero(is_metered), np.flatnonzero(~is_metered)
