"""The fast path of rendering: rows of pixels, each taken through all stages by one kernel.

A renderer supplies the kernel that resolves the surfaces of a row, a shader the one that lights them, a sensor the one
that develops their radiance. For each combination a template, ``_finishing`` or ``_picture_lighting``, makes a function
that calls these kernels; it is compiled as a whole.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.render.attributes import ResolveScratch, SurfaceRow, new_resolve_scratch
from sim.render.compilation import announce_compilation, closure_kernel, forget_stale_kernels, row_kernel
from sim.render.smooth_edges import SmoothScratch, new_smooth_scratch, smooth_row


@dataclass(frozen=True, slots=True)
class RowStage:
    """One stage of a row of pixels.

    Attributes:
        kernel: a ``row_kernel``. A renderer's writes the surfaces of a row: ``(seen, row, scratch, surfaces)``, where
            ``seen`` is what ``visible`` returns, ``surfaces`` a ``SurfaceRow``, and the scratch has its ``colour`` and
            ``normal``. A shader's writes the radiance (C, W) float32 of a row: ``(light, row, surfaces, scratch,
            radiance)``, where ``light`` is what ``row_light`` returns. A sensor's writes the picture: ``(development,
            row, scratch, radiance)``, see ``RowSensor.develop_first``.
        new_scratch: returns a NamedTuple of the kernel's scratch arrays, for rows of W pixels.
        channels: C, of a shader.
    """

    kernel: Callable[..., Any]
    new_scratch: Callable[[int], Any]
    channels: int = 3


class RowScratch(NamedTuple):
    """Scratch of all stages."""

    resolve: Any
    light: Any
    develop: Any


@row_kernel()
def _keep(development: None, row: int, scratch: None, radiance: NDArray[np.float32]) -> None:
    """Leave the radiance of a row as it is."""


_KEEP = RowStage(_keep, lambda width: None)


def finish_rows(
    resolving: RowStage,
    seen: Any,
    rows: NDArray[np.int64],
    lighting: RowStage,
    light: Any,
    radiance: NDArray[np.float32],
    developing: RowStage = _KEEP,
    development: Any = None,
) -> None:
    """Write ids and radiance of the given rows (R,), and develop them.

    Args:
        light, development: arrays of the two stages.
        radiance: (R, C, W); or (1, C, W), scratch for a row of it on its way to the picture.
    """
    width = seen.depth_m.shape[1]
    scratch = RowScratch(*(_scratch(stage, width) for stage in (resolving, lighting, developing)))
    kernel = _compiled(_finishing, resolving.kernel, lighting.kernel, developing.kernel)
    kernel(seen, rows, light, development, radiance, scratch)


def finish_smooth_rows(
    resolving: RowStage,
    seen: Any,
    lit: NDArray[np.float32],
    lit_step: int,
    lighting: RowStage,
    light: Any,
    radiance: NDArray[np.float32],
    developing: RowStage = _KEEP,
    development: Any = None,
) -> None:
    """Write ids and radiance of all rows, smooth their edges, and develop them; see ``sim.render.smooth_edges``.

    Args:
        lit: (R, C, W) radiance of the rows 0, ``lit_step``, …, that are lit already; none of the others.
        light, development: arrays of the two stages.
        radiance: (H, C, W); or (2, C, W), scratch for two rows on their way to the picture.
    """
    width = seen.depth_m.shape[1]
    scratch = RowScratch(*(_scratch(stage, width) for stage in (resolving, lighting, developing)))
    kernel = _compiled(_smoothing, resolving.kernel, lighting.kernel, developing.kernel)
    kernel(seen, lit, lit_step, light, development, radiance, _smooth_scratch(width, lighting.channels), scratch)


def light_picture(lighting: RowStage, light: Any, gbuffer: GBuffer) -> NDArray[np.float32]:
    """Return the radiance (H, C, W) of a G-buffer by the kernel of a shader's rows."""
    height, width = gbuffer.depth_m.shape
    radiance = np.empty((height, lighting.channels, width), np.float32)
    kernel = _compiled(_picture_lighting, lighting.kernel)
    kernel(gbuffer, light, new_resolve_scratch(width), _scratch(lighting, width), radiance)
    return radiance


@lru_cache(maxsize=16)
def _scratch(stage: RowStage, width: int) -> Any:
    """Return the scratch of a stage, allocated once: fresh memory costs a tenth of a millisecond."""
    return stage.new_scratch(width)


_smooth_scratch = lru_cache(maxsize=16)(new_smooth_scratch)


@cache
def _compiled(template: Callable[..., FunctionType], *kernels: Any) -> Any:
    """Return the compiled form of ``template(*kernels)``, a function that calls these kernels."""
    names = [f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}" for kernel in kernels]
    compiled = closure_kernel(template(*kernels), ".".join([template.__name__, *names]))
    for kernel in kernels:
        forget_stale_kernels(Path(kernel.py_func.__code__.co_filename).parent, compiled)
    announce_compilation(compiled)
    return compiled


def _finishing(resolve: Callable[..., None], light_row: Callable[..., None], develop_row: Callable[..., None]) -> Any:
    """Return the function that takes each row of a picture through the kernels of three stages."""

    def finish(
        seen: Any,
        rows: NDArray[np.int64],
        light: Any,
        development: Any,
        radiance: NDArray[np.float32],
        scratch: RowScratch,
    ) -> None:
        colour, normal = scratch.resolve.colour, scratch.resolve.normal
        for k in range(rows.shape[0]):
            row = rows[k]
            radiance_row = radiance[k % radiance.shape[0]]
            surfaces = SurfaceRow(colour, seen.depth_m[row], seen.instance_id[row], normal)
            resolve(seen, row, scratch.resolve, surfaces)
            light_row(light, row, surfaces, scratch.light, radiance_row)
            develop_row(development, row, scratch.develop, radiance_row)

    return finish


@row_kernel()
def _copy(source: NDArray[np.float32], target: NDArray[np.float32]) -> None:
    """Copy rows; a slice's assignment would ask for memory."""
    for channel in range(source.shape[0]):
        for column in range(source.shape[1]):
            target[channel, column] = source[channel, column]


def _smoothing(resolve: Callable[..., None], light_row: Callable[..., None], develop_row: Callable[..., None]) -> Any:
    """Return the function that takes the rows of a picture through the kernels of three stages, with smooth edges.

    A row waits for the next one, with which it shares edges: two are held at a time.
    """

    def finish(
        seen: Any,
        lit: NDArray[np.float32],
        lit_step: int,
        light: Any,
        development: Any,
        radiance: NDArray[np.float32],
        smoothing: SmoothScratch,
        scratch: RowScratch,
    ) -> None:
        colour, normal = scratch.resolve.colour, scratch.resolve.normal
        height, kept = seen.depth_m.shape[0], radiance.shape[0]
        smoothing.counts[0] = smoothing.counts[1] = 0
        for row in range(height + 1):
            here, before = radiance[row % kept], radiance[(row - 1) % kept]
            if row % lit_step == 0 and row // lit_step < lit.shape[0]:
                _copy(lit[row // lit_step], here)
            elif row < height:
                surfaces = SurfaceRow(colour, seen.depth_m[row], seen.instance_id[row], normal)
                resolve(seen, row, scratch.resolve, surfaces)
                light_row(light, row, surfaces, scratch.light, here)
            if row > 0:
                smooth_row(seen, row - 1, before, here if row < height else before, smoothing)
                develop_row(development, row - 1, scratch.develop, before)

    return finish


def _picture_lighting(light_row: Callable[..., None]) -> Any:
    """Return the function that lights each row of a G-buffer by the kernel of a shader."""

    def light_rows(
        gbuffer: GBuffer, light: Any, resolve: ResolveScratch, scratch: Any, radiance: NDArray[np.float32]
    ) -> None:
        colour, normal = resolve.colour, resolve.normal
        base_colour_rgb, normal_world = gbuffer.base_colour_rgb, gbuffer.normal_world
        for row in range(gbuffer.depth_m.shape[0]):
            for column in range(gbuffer.depth_m.shape[1]):
                colour[column] = (
                    np.uint32(base_colour_rgb[row, column, 0])
                    | np.uint32(base_colour_rgb[row, column, 1]) << np.uint32(8)
                    | np.uint32(base_colour_rgb[row, column, 2]) << np.uint32(16)
                )
                for k in range(3):
                    normal[k, column] = normal_world[row, column, k]
            surfaces = SurfaceRow(colour, gbuffer.depth_m[row], gbuffer.instance_id[row], normal)
            light_row(light, row, surfaces, scratch, radiance[row])

    return light_rows
