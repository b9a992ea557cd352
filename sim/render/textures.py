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
        texels: (N,) uint32, ``R | G << 8 | B << 16``, all levels of all textures one after the other,
            row-major.
        offset: (T, L) int64, where a level begins in ``texels``.
        width, height: (T, L) int32.
        level_count: (T,) int32; 1 for textures that are not smooth.
        smooth: (T,) bool, interpolate between texels.
    """

    texels: NDArray[np.uint32]
    offset: NDArray[np.int64]
    width: NDArray[np.int32]
    height: NDArray[np.int32]
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
    texels = np.empty(sum(level.shape[0] * level.shape[1] for chain in chains for level in chain), np.uint32)
    used = 0
    for t, chain in enumerate(chains):
        for k, level in enumerate(chain):
            height[t, k], width[t, k] = level.shape[:2]
            offset[t, k] = used
            end = used + level.shape[0] * level.shape[1]
            rgbx = np.zeros((*level.shape[:2], 4), dtype=np.uint8)
            rgbx[..., :3] = level
            texels[used:end] = rgbx.view("<u4").ravel()
            used = end
    return TexturePool(
        texels,
        offset,
        width,
        height,
        np.array([len(chain) for chain in chains], dtype=np.int32),
        np.array([texture.smooth for texture in textures], dtype=np.bool_),
    )


def _mip_chain(texture: Texture) -> list[NDArray[np.uint8]]:
    chain = [np.ascontiguousarray(texture.rgb)]
    while texture.smooth and min(chain[-1].shape[:2]) > 1:
        rows, columns = chain[-1].shape[:2]
        chain.append(cv2.resize(chain[-1], (columns // 2, rows // 2), interpolation=cv2.INTER_AREA))
    return chain
