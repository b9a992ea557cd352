"""Textures of a world in one flat pool of packed texels, with their mip levels."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture

_ROOM = 8
"""A pool has room for one more texel in so many."""


class TexturePool(NamedTuple):
    """Textures as arrays for kernels: T textures, at most L mip levels each.

    Attributes:
        texels: (N,) uint32, ``R | G << 8 | B << 16``, all levels of all textures one after the other, each in
            tiles of 4x4 texels (see ``sim.render.rows``).
        where: (T, L, 2) int32, first texel of a level in ``texels``, and texels from a row of its tiles to the next.
        scale: (T, L, 2) float32, width and height of a level in those of level 0.
        last: (T, L, 2) float32, number of a level's last column and row.
        level_count: (T,) int32; 1 for textures that are not smooth.
        smooth: (T,) bool, interpolate between texels.
    """

    texels: NDArray[np.uint32]
    where: NDArray[np.int32]
    scale: NDArray[np.float32]
    last: NDArray[np.float32]
    level_count: NDArray[np.int32]
    smooth: NDArray[np.bool_]


class TextureStore:
    """Packs lists of textures one after the other; those with which two lists begin stay where they are.

    A mip level halves the one before it, each texel the mean (of sRGB codes) of the four it covers.
    """

    def __init__(self) -> None:
        self._textures: list[Texture] = []
        self._texels = np.zeros(0, dtype=np.uint32)

    def pool(self, textures: Sequence[Texture]) -> TexturePool:
        """Return the pool of ``textures``, in their order; it shares memory with the one before, which is invalid."""
        sizes = [_level_sizes(texture) for texture in textures]
        count, depth = len(sizes), max((len(levels) for levels in sizes), default=1)
        where = np.zeros((count, depth, 2), dtype=np.int32)
        scale, last = np.zeros((count, depth, 2), np.float32), np.zeros((count, depth, 2), np.float32)
        used, first = 0, []
        for t, levels in enumerate(sizes):
            first.append(used)
            for k, (rows, columns) in enumerate(levels):
                where[t, k] = used, 16 * (columns // 4 + 1)
                scale[t, k] = columns / levels[0][1], rows / levels[0][0]
                last[t, k] = columns - 1, rows - 1
                used += _texel_count(rows, columns)
        kept = count_alike(self._textures, textures)
        texels = self._with_room((*first, used)[kept], used)
        for t in range(kept, count):
            _write_mip_chain(textures[t], sizes[t], texels[first[t] :])
        self._textures = list(textures)
        return TexturePool(
            texels,
            where,
            scale,
            last,
            np.array([len(levels) for levels in sizes], dtype=np.int32),
            np.array([texture.smooth for texture in textures], dtype=np.bool_),
        )

    def _with_room(self, kept: int, used: int) -> NDArray[np.uint32]:
        """Return ``used`` texels, of which the first ``kept`` stay."""
        if used > len(self._texels):
            # Zeros take no memory until they are written: room for other textures at the end costs nothing.
            texels = np.zeros(used + used // _ROOM, dtype=np.uint32)
            texels[:kept] = self._texels[:kept]
            self._texels = texels
        self._texels[kept:used] = 0
        return self._texels[:used]


def count_alike(some: Sequence[object], others: Sequence[object]) -> int:
    """Return the number of objects with which both lists begin."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] is pair[1], zip(some, others, strict=False)))


def _level_sizes(texture: Texture) -> list[tuple[int, int]]:
    """Return (height, width) of every mip level, from the texture itself down."""
    height, width = texture.rgb.shape[:2]
    sizes = [(height, width)]
    while texture.smooth and min(height, width) > 1:
        height, width = height // 2, width // 2
        sizes.append((height, width))
    return sizes


def _texel_count(height: int, width: int) -> int:
    """Return the number of texels of a level, including those that fill its last tiles."""
    return 16 * (height // 4 + 1) * (width // 4 + 1)


def _write_mip_chain(texture: Texture, sizes: list[tuple[int, int]], texels: NDArray[np.uint32]) -> None:
    """Write all levels to the start of ``texels``, one by one: together those of a town have a hundred megabytes."""
    level = np.ascontiguousarray(texture.rgb)
    for rows, columns in sizes:
        if level.shape[:2] != (rows, columns):
            level = np.asarray(cv2.resize(level, (columns, rows), interpolation=cv2.INTER_AREA), dtype=np.uint8)
        _write_tiles(level, texels[: _texel_count(rows, columns)])
        texels = texels[_texel_count(rows, columns) :]


def _write_tiles(rgb: NDArray[np.uint8], texels: NDArray[np.uint32]) -> None:
    """Write a level (H, W, 3) to ``texels`` (N,), zero before, in tiles of 4x4, filled up with the last row and
    column: at least one of each is added; see ``sim.render.rows``.
    """
    height, width = rgb.shape[:2]
    rows, columns = height // 4 + 1, width // 4 + 1
    tiles = texels.view(np.uint8).reshape(rows, columns, 4, 4, 4)
    for row in range(4):
        down = np.minimum(np.arange(row, 4 * rows, 4), height - 1)
        widened = cv2.copyMakeBorder(rgb[down], 0, 0, 0, 4 * columns - width, cv2.BORDER_REPLICATE)
        tiles[:, :, row, :, :3] = widened.reshape(rows, columns, 4, 3)
