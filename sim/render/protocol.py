"""The contract of a renderer, and the renderers by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import Camera
from sim.render.pybullet import PybulletRenderer
from sim.render.raster import Raster
from sim.world import World


class Renderer(Protocol):
    """Draws one world as it is at the time of the call."""

    def gbuffer(self, camera: Camera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5) -> GBuffer:
        """Return the visible surfaces, in fresh arrays.

        Args:
            T_world_camera: (4, 4) rigid pose.
            pixel_offset: where in a pixel it is sampled; 0.5 is its centre.
        """
        ...

    def normals(self, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return ``normal_world`` of the ``gbuffer``, in a fresh array."""
        ...


RENDERERS: dict[str, Callable[[World], Renderer]] = {"raster": Raster, "pybullet": PybulletRenderer}


def create_renderer(name: str, world: World) -> Renderer:
    """Return the renderer ``name`` of ``world``.

    Raises:
        ValueError: if there is none of that name.
    """
    if name not in RENDERERS:
        raise ValueError(f"renderer: expected one of {', '.join(RENDERERS)}, got {name!r}")
    return RENDERERS[name](world)
