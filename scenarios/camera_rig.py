"""The cameras of an episode: renderer and sensor of the camera that the tracker watches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import RendererName
from sim.checks import check
from sim.optics import PinholeCamera
from sim.render.pipeline import Capture, Sensor, Shader, capture
from sim.render.protocol import Renderer, create_renderer
from sim.world import World


class Rig(Protocol):
    """One camera, or several on one carrier.

    Attributes:
        camera: the one that the tracker watches.
    """

    camera: PinholeCamera

    def larger_view(self, shader: Shader, T_world_camera: NDArray[np.float64], scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high."""
        ...

    def normals(self, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the unit normals (H, W, 3) of the visible surfaces, world frame; 0 where there is none."""
        ...


class SingleCamera:
    """A ``Rig`` of one camera."""

    def __init__(
        self,
        world: World,
        camera: PinholeCamera,
        renderer: RendererName,
        sensor: Sensor[Any],
        *,
        through: Callable[[Renderer], Renderer] | None = None,
    ) -> None:
        """Stand before a world.

        Args:
            through: returns the renderer of what is seen through something, of the one that draws the world.
        """
        self.camera = camera
        self._renderer = create_renderer(renderer, world)
        if through is not None:
            self._renderer = through(self._renderer)
        self._sensor = sensor
        self._frame = 0
        self._settings: Any = None

    def take(self, shader: Shader, T_world_camera: NDArray[np.float64], frame: int, **exposing: Any) -> Capture:
        """Take a picture of the current world; the sensor's loops take one step.

        Args:
            frame: index, >= 0; it determines the noise.
            exposing: see ``sim.render.pipeline.capture``.
        """
        seen = capture(self._renderer, shader, self._sensor, self.camera, T_world_camera, frame, **exposing)
        self._frame, self._settings = frame, seen.picture.settings
        return seen

    def normals(self, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """See ``Rig``."""
        return self._renderer.normals(self.camera, T_world_camera)

    def larger_view(self, shader: Shader, T_world_camera: NDArray[np.float64], scale: float) -> NDArray[np.uint8]:
        """See ``Rig``.

        Raises:
            ValueError: before the first picture, whose settings it takes.
        """
        check("larger_view", self._settings is not None, "a picture taken before", "none")
        width_px, height_px = (2 * round(0.5 * scale * side) for side in (self.camera.width_px, self.camera.height_px))
        wide = PinholeCamera(width_px, height_px, self.camera.focal_px)
        radiance = shader.shade(self._renderer.gbuffer(wide, T_world_camera), wide, T_world_camera)
        return self._sensor.develop(radiance, wide, self._frame, self._settings).image_rgb
