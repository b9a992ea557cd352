"""The background as an eigenspace for each block of the picture, and how far a picture departs from it (paper D, 2.1).

The picture is enlarged ``ENLARGED`` times, as the authors enlarged theirs, and cut into blocks of ``BLOCK_PX`` pixels.
What is left over at the right and lower border belongs to no block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

BLOCK_PX, ENLARGED = 8, 2
"""Section 4.1. The block is measured in the enlarged picture."""
_ROUNDING_VARIANCE = 1.0 / 12.0
"""Of whole grey levels. A block that never changes has no variance of its own to compare with."""


@dataclass(frozen=True, eq=False)
class BlockEigenspaces:
    """Eigenspaces of B blocks of n = 64 pixels, in rows from the top left.

    Attributes:
        rows, columns: of blocks; B is their product.
        mean: (B, n) float32, grey levels.
        axes: (K, n) float32, eigenvectors divided by the root of their eigenvalues, those of one block after another.
        first: (B + 1,) int64; block b has the axes ``first[b]`` to ``first[b + 1]``, D_b of them.
    """

    rows: int
    columns: int
    mean: NDArray[np.float32]
    axes: NDArray[np.float32]
    first: NDArray[np.int64]

    @property
    def dimensions(self) -> NDArray[np.int64]:
        """(B,) D, the number of eigenvectors of each block."""
        return np.diff(self.first)

    def relative_variation(self, grey: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Return r_D (rows, columns) of a picture (H, W), equation (1): about 1 where it is like the background."""
        values = np.ascontiguousarray(blocks_of(enlarged(grey)), dtype=np.float32)
        return relative_variations(values, self.mean, self.axes, self.first).reshape(self.rows, self.columns)


def enlarged(grey: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the picture at twice its size, bilinear (the paper does not say how its digital zoom works)."""
    picture: NDArray[np.uint8] = cv2.resize(grey, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_LINEAR)
    return picture


def blocks_of(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the blocks (B, n) of a picture that is already enlarged."""
    rows, columns = picture.shape[0] // BLOCK_PX, picture.shape[1] // BLOCK_PX
    cut = picture[: rows * BLOCK_PX, : columns * BLOCK_PX].reshape(rows, BLOCK_PX, columns, BLOCK_PX)
    blocks: NDArray[np.uint8] = cut.transpose(0, 2, 1, 3).reshape(rows * columns, BLOCK_PX * BLOCK_PX)
    return blocks


def learn(greys: Sequence[NDArray[np.uint8]], contribution: float) -> BlockEigenspaces:
    """Learn the eigenspaces from pictures (H, W) without intruders.

    D of a block is the least number of eigenvectors whose eigenvalues make up ``contribution`` of their sum.

    Raises:
        ValueError: for fewer than two pictures, pictures of different sizes, or a contribution outside (0, 1].
    """
    if not 0.0 < contribution <= 1.0:
        raise ValueError(f"contribution: expected a share in (0, 1], got {contribution}")
    sizes = {grey.shape for grey in greys}
    if len(greys) < 2 or len(sizes) != 1:
        raise ValueError(f"greys: expected two pictures or more of one size, got {len(greys)} of {len(sizes)} sizes")
    pictures = np.stack([enlarged(grey) for grey in greys])
    rows, columns = pictures.shape[1] // BLOCK_PX, pictures.shape[2] // BLOCK_PX
    means, axes, dimensions = [], [], []
    for row in range(rows):
        strip = pictures[:, row * BLOCK_PX : (row + 1) * BLOCK_PX]
        values = np.stack([blocks_of(each) for each in strip], axis=1).astype(np.float32)
        mean, scaled, kept = _strip_eigenspaces(values, contribution)
        means.append(mean)
        axes.append(scaled)
        dimensions.append(kept)
    first = np.concatenate([[0], np.cumsum(np.concatenate([*dimensions, np.zeros(0, np.int64)]))])
    pixels = BLOCK_PX * BLOCK_PX
    return BlockEigenspaces(
        rows,
        columns,
        np.concatenate([*means, np.empty((0, pixels), np.float32)]),
        np.concatenate([*axes, np.empty((0, pixels), np.float32)]),
        first.astype(np.int64),
    )


def _strip_eigenspaces(
    values: NDArray[np.float32], contribution: float
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int64]]:
    """Return mean (C, n), scaled axes (K, n) and numbers of axes (C,) of C blocks seen N times, ``values`` (C, N, n).

    ``C = 1 / (N - 1) Σ (x - m)(x - m)ᵗ``; its eigenvalues λ are bounded from below by the variance of rounding.
    """
    mean = values.mean(axis=1)
    centred = values - mean[:, None]
    covariance = (centred.transpose(0, 2, 1) @ centred).astype(np.float64) / (values.shape[1] - 1)
    eigenvalues, vectors = np.linalg.eigh(covariance)
    eigenvalues, vectors = np.maximum(eigenvalues[:, ::-1], 0.0), vectors[:, :, ::-1]
    total = eigenvalues.sum(axis=1, keepdims=True)
    reached = np.cumsum(eigenvalues, axis=1) >= (contribution - 1e-9) * total
    dimensions = reached.argmax(axis=1).astype(np.int64) + 1
    scaled = vectors / np.sqrt(np.maximum(eigenvalues, _ROUNDING_VARIANCE))[:, None]
    kept = np.arange(eigenvalues.shape[1]) < dimensions[:, None]
    return mean, scaled.transpose(0, 2, 1)[kept].astype(np.float32), dimensions


@njit(cache=True, fastmath={"nsz", "contract", "reassoc"})
def relative_variations(
    values: NDArray[np.float32], mean: NDArray[np.float32], axes: NDArray[np.float32], first: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Relative variation of blocks, equation (1).

    ``s = Eᵗ (x − m)``, ``r_D = 1 / D Σ_i s_i² / λ_i``; the axes hold ``e_i / √λ_i``.

    Reading: the mean is removed and s is squared, without which r would not be a ratio of variances.

    Args:
        values: (B, n) blocks. mean, axes, first: as in ``BlockEigenspaces``.

    Returns:
        (B,), >= 0.
    """
    count, pixels = values.shape
    r = np.empty(count)
    for b in range(count):
        total = np.float32(0.0)
        for k in range(first[b], first[b + 1]):
            s = np.float32(0.0)
            for j in range(pixels):
                s += axes[k, j] * (values[b, j] - mean[b, j])
            total += s * s
        r[b] = total / (first[b + 1] - first[b])
    return r


def likelihood(
    r: NDArray[np.float64],
    dimensions: NDArray[np.int64],
    gain: float,
    threshold_few: float,
    threshold_many: float,
    few: int,
) -> NDArray[np.float64]:
    """Return f in (0, 1), equation (2): ``f = 1 / (1 + exp(−alpha (r_D − v_D)))``.

    Args:
        r: (...) relative variation. dimensions: (...) D of each block.
        gain: alpha. threshold_few, threshold_many: v_D for D <= ``few`` and above.
    """
    threshold = np.where(dimensions <= few, threshold_few, threshold_many)
    # Beyond 700 the exponential overflows, and f is 0 or 1 long before.
    f: NDArray[np.float64] = 1.0 / (1.0 + np.exp(np.clip(-gain * (r - threshold), -700.0, 700.0)))
    return f
