"""Textures of a world in one flat pool of packed texels, with their mip levels."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture


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


class _Place(NamedTuple):
    """Where a texture is packed: its rows of ``TexturePool``, and its number of texels."""

    where: NDArray[np.int32]
    scale: NDArray[np.float32]
    last: NDArray[np.float32]
    texels: int


class TextureStore:
    """Packs textures, each once for all pools; the place of one that is no longer held serves another.

    A mip level halves the one before it, each texel the mean (of sRGB codes) of the four it covers.
    """

    def __init__(self) -> None:
        self._places: WeakKeyDictionary[Texture, _Place] = WeakKeyDictionary()
        self._texels = np.zeros(0, dtype=np.uint32)
        self._used = 0
        self._left: dict[int, list[int]] = {}

    def pool(self, textures: Sequence[Texture]) -> TexturePool:
        """Return the pool of ``textures``, in their order; it is valid while they are held."""
        new = [texture for texture in textures if texture not in self._places]
        self._make_room(sum(_place(_level_sizes(texture)).texels for texture in new))
        for texture in new:
            self._places[texture] = self._packed(texture)
        places = [self._places[texture] for texture in textures]
        shape = len(places), max((len(place.where) for place in places), default=1), 2
        where, scale, last = np.zeros(shape, np.int32), np.zeros(shape, np.float32), np.zeros(shape, np.float32)
        for t, place in enumerate(places):
            levels = len(place.where)
            where[t, :levels], scale[t, :levels], last[t, :levels] = place.where, place.scale, place.last
        return TexturePool(
            self._texels,
            where,
            scale,
            last,
            np.array([len(place.where) for place in places], dtype=np.int32),
            np.array([texture.smooth for texture in textures], dtype=np.bool_),
        )

    def _make_room(self, count: int) -> None:
        """Make room for ``count`` more texels; pools of before keep the array that they have."""
        needed = self._used + count
        if needed > len(self._texels):
            # Zeros take no memory until they are written, so that room for the textures of other copies costs nothing.
            texels = np.zeros(2 * needed, dtype=np.uint32)
            texels[: self._used] = self._texels[: self._used]
            self._texels = texels

    def _packed(self, texture: Texture) -> _Place:
        """Pack a texture where one was that is no longer held, or after all others."""
        sizes = _level_sizes(texture)
        place = _place(sizes)
        left = self._left.setdefault(place.texels, [])
        first = left.pop() if left else self._used
        self._used = max(self._used, first + place.texels)
        _write_mip_chain(texture, sizes, self._texels[first:])
        weakref.finalize(texture, left.append, first)
        place.where[:, 0] += first
        return place


def _level_sizes(texture: Texture) -> list[tuple[int, int]]:
    """Return (height, width) of every mip level, from the texture itself down."""
    height, width = texture.rgb.shape[:2]
    sizes = [(height, width)]
    while texture.smooth and min(height, width) > 1:
        height, width = height // 2, width // 2
        sizes.append((height, width))
    return sizes


def _place(sizes: Sequence[tuple[int, int]]) -> _Place:
    """Return the place of a texture with levels of these sizes at the start of a pool."""
    rows, columns = np.array(sizes).T
    counts = [_texel_count(*size) for size in sizes]
    return _Place(
        np.column_stack([np.cumsum([0, *counts[:-1]]), 16 * (columns // 4 + 1)]).astype(np.int32),
        np.column_stack([columns / columns[0], rows / rows[0]]).astype(np.float32),
        np.column_stack([columns - 1, rows - 1]).astype(np.float32),
        sum(counts),
    )


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
