"""All textures of a world in one flat pool of packed texels, with their mip levels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture


class TexturePool(NamedTuple):
    """Textures as the kernels read them. T textures, at most L mip levels each.

    Attributes:
        texels: (N,) uint32, ``R | G << 8 | B << 16``, all levels of all textures one after the other, each in
            tiles of 4x4 texels (see ``sim.render.sampling``).
        offset: (T, L) int64, where a level begins in ``texels``.
        width, height: (T, L) int32.
        row_pitch: (T, L) int32, from a row of tiles to the next.
        level_count: (T,) int32; 1 for textures that are not smooth.
        smooth: (T,) bool, interpolate between texels.
    """

    texels: NDArray[np.uint32]
    offset: NDArray[np.int64]
    width: NDArray[np.int32]
    height: NDArray[np.int32]
    row_pitch: NDArray[np.int32]
    level_count: NDArray[np.int32]
    smooth: NDArray[np.bool_]


def pack_textures(textures: Sequence[Texture]) -> TexturePool:
    """Return the pool of ``textures``, in their order.

    A mip level halves the one before it, each texel the mean (of sRGB codes) of the four it covers.
    """
    chains = [_mip_chain(texture) for texture in textures]
    count, depth = len(chains), max((len(chain) for chain in chains), default=1)
    offset = np.zeros((count, depth), dtype=np.int64)
    width = np.ones((count, depth), dtype=np.int32)
    height = np.ones((count, depth), dtype=np.int32)
    row_pitch = np.zeros((count, depth), dtype=np.int32)
    parts = []
    used = 0
    for t, chain in enumerate(chains):
        for k, level in enumerate(chain):
            height[t, k], width[t, k] = level.shape[:2]
            offset[t, k] = used
            row_pitch[t, k] = 16 * (level.shape[1] // 4 + 1)
            parts.append(_tiled(level))
            used += parts[-1].size
    return TexturePool(
        np.concatenate(parts) if parts else np.empty(0, np.uint32),
        offset,
        width,
        height,
        row_pitch,
        np.array([len(chain) for chain in chains], dtype=np.int32),
        np.array([texture.smooth for texture in textures], dtype=np.bool_),
    )


def _mip_chain(texture: Texture) -> list[NDArray[np.uint8]]:
    chain: list[NDArray[np.uint8]] = [np.ascontiguousarray(texture.rgb)]
    while texture.smooth and min(chain[-1].shape[:2]) > 1:
        rows, columns = chain[-1].shape[:2]
        half = cv2.resize(chain[-1], (columns // 2, rows // 2), interpolation=cv2.INTER_AREA)
        chain.append(half.astype(np.uint8))
    return chain


def _tiled(rgb: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Return packed texels (N,) in tiles of 4x4, filled up with the last row and column: at least one of each is
    added; see ``sim.render.sampling``.
    """
    height, width = rgb.shape[:2]
    rows, columns = height // 4 + 1, width // 4 + 1
    rgbx = np.zeros((4 * rows, 4 * columns, 4), dtype=np.uint8)
    rgbx[:height, :width, :3] = rgb
    rgbx[height:, :width] = rgbx[height - 1 : height, :width]
    rgbx[:, width:] = rgbx[:, width - 1 : width]
    return rgbx.view("<u4").reshape(rows, 4, columns, 4).swapaxes(1, 2).ravel()
