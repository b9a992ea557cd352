"""Features of a patch on a grid of cells of 4 x 4 samples: oriented gradients, colour terms, and grey.

* Histograms of oriented gradients, 31 numbers a cell: Felzenszwalb, Girshick, McAllester, Ramanan, Object detection
  with discriminatively trained part-based models, TPAMI 2010, section 6: 18 directions, 9 orientations, 4 textures.
* Colour terms: shares of the eleven basic colour terms (Berlin, Kay, Basic color terms, 1969) in the mean colour of a
  cell, by its distance to a typical colour of each term in CIE L*a*b*. Of their use: Danelljan, Khan, Felsberg, van de
  Weijer, Adaptive color attributes for real-time visual tracking, CVPR 2014; they learn the shares from pictures.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

CELL = 4
"""Samples a side of a cell."""
_DIRECTIONS = 18
_ORIENTATIONS = _DIRECTIONS // 2
_GRADIENTS = _DIRECTIONS + _ORIENTATIONS + 4
_TRUNCATED_AT = 0.2
_TEXTURE_WEIGHT = 0.2357
_BLACK, _GREY, _WHITE = [0, 0, 0], [128, 128, 128], [255, 255, 255]
_RED, _ORANGE, _YELLOW, _BROWN = [220, 0, 0], [255, 140, 0], [255, 230, 0], [128, 77, 26]
_GREEN, _BLUE, _PURPLE, _PINK = [0, 160, 0], [0, 0, 255], [140, 40, 160], [255, 140, 190]
_TERMS_RGB = np.array(
    [_BLACK, _GREY, _WHITE, _RED, _ORANGE, _YELLOW, _BROWN, _GREEN, _BLUE, _PURPLE, _PINK], np.float32
)
_TERM_WIDTH = 25.0
"""Standard deviation of a colour term in L*a*b*."""
_TERM_WEIGHT = 0.5
"""Of colour terms against gradients."""
_LEVELS = 32
CHANNELS = _GRADIENTS + len(_TERMS_RGB) + 1


def _shares_of_terms() -> NDArray[np.float32]:
    """Return the shares (32, 32, 32, 11) of the terms by red, green and blue in steps of 8."""

    def lab(colours_rgb: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(cv2.cvtColor(colours_rgb.reshape(1, -1, 3) / np.float32(255), cv2.COLOR_RGB2Lab)[0])

    levels = ((np.arange(_LEVELS) + 0.5) * (256 / _LEVELS)).astype(np.float32)
    colours = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1)
    away = ((lab(colours)[:, None] - lab(_TERMS_RGB)) ** 2).sum(-1)
    weights = np.exp(-0.5 * (away - away.min(1, keepdims=True)) / _TERM_WIDTH**2)
    shares = weights / weights.sum(1, keepdims=True)
    return shares.reshape(_LEVELS, _LEVELS, _LEVELS, -1).astype(np.float32)


def _directions_of_gradients() -> NDArray[np.uint8]:
    """Return the direction, 0 to 17, of a gradient (511, 511) by its y and its x component plus 255."""
    y, x = np.meshgrid(np.arange(-255, 256), np.arange(-255, 256), indexing="ij")
    return (np.rint(np.arctan2(y, x) * _DIRECTIONS / (2.0 * np.pi)).astype(int) % _DIRECTIONS).astype(np.uint8)


_SHARES = _shares_of_terms()
_DIRECTION = _directions_of_gradients()


def cell_features(patch_rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return features (43, rows, columns) of the cells of a patch (4 rows, 4 columns, 3)."""
    rows, columns = patch_rgb.shape[0] // CELL, patch_rgb.shape[1] // CELL
    features = np.empty((CHANNELS, rows, columns), np.float32)
    features[:_GRADIENTS] = gradients(patch_rgb)
    mean_rgb = cv2.resize(patch_rgb, (columns, rows), interpolation=cv2.INTER_AREA)
    red, green, blue = np.moveaxis(mean_rgb // (256 // _LEVELS), -1, 0)
    shares = np.moveaxis(_SHARES[red, green, blue], -1, 0)
    features[_GRADIENTS:-1] = np.float32(_TERM_WEIGHT) * (shares - np.float32(1 / len(_TERMS_RGB)))
    features[-1] = cv2.cvtColor(mean_rgb, cv2.COLOR_RGB2GRAY) / np.float32(255) - np.float32(0.5)
    return features


def gradients(patch_rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return histograms of oriented gradients (31, rows, columns) of the cells of a patch (4 rows, 4 columns, 3)."""
    return np.asarray(_normalised(_histograms(patch_rgb, _DIRECTION)))


@njit(cache=True, fastmath=True)
def _histograms(patch, directions):  # type: ignore[no-untyped-def]
    """Return lengths of gradients by direction (rows, columns, 18): each sample's is shared among four cells."""
    height, width = patch.shape[:2]
    # A cell of margin takes the shares that fall outside.
    sums = np.zeros((height // CELL + 2, width // CELL + 2, _DIRECTIONS), np.float32)
    for i in range(height):
        above, below = max(i - 1, 0), min(i + 1, height - 1)
        y = (i + 0.5) / CELL + 0.5
        row = int(y)
        low_y = np.float32(y - row)
        high_y = np.float32(1) - low_y
        for j in range(width):
            left, right = max(j - 1, 0), min(j + 1, width - 1)
            most, best_y, best_x = np.int64(0), np.int64(255), np.int64(255)
            for channel in range(3):
                dy = np.int64(patch[below, j, channel]) - np.int64(patch[above, j, channel])
                dx = np.int64(patch[i, right, channel]) - np.int64(patch[i, left, channel])
                if dx * dx + dy * dy > most:
                    most, best_y, best_x = dx * dx + dy * dy, dy + 255, dx + 255
            if most == 0:
                continue
            length, direction = np.sqrt(np.float32(most)), directions[best_y, best_x]
            x = (j + 0.5) / CELL + 0.5
            column = int(x)
            low_x = np.float32(x - column)
            high_x = np.float32(1) - low_x
            sums[row, column, direction] += length * high_y * high_x
            sums[row, column + 1, direction] += length * high_y * low_x
            sums[row + 1, column, direction] += length * low_y * high_x
            sums[row + 1, column + 1, direction] += length * low_y * low_x
    return sums[1:-1, 1:-1]


@njit(cache=True, fastmath=True)
def _normalised(sums):  # type: ignore[no-untyped-def]
    """Return features (31, rows, columns): sums relative to the energies of the four blocks of cells around each."""
    rows, columns = sums.shape[:2]
    energy = np.zeros((rows + 2, columns + 2), np.float32)
    for i in range(rows):
        for j in range(columns):
            for k in range(_ORIENTATIONS):
                energy[i + 1, j + 1] += (sums[i, j, k] + sums[i, j, k + _ORIENTATIONS]) ** 2
    energy[0], energy[-1] = energy[1], energy[-2]
    energy[:, 0], energy[:, -1] = energy[:, 1], energy[:, -2]
    scales = np.empty((rows + 1, columns + 1), np.float32)
    for i in range(rows + 1):
        for j in range(columns + 1):
            block = energy[i, j] + energy[i, j + 1] + energy[i + 1, j] + energy[i + 1, j + 1]
            # 1: gradients go up to 255.
            scales[i, j] = np.float32(1) / np.sqrt(block + np.float32(1))
    features = np.zeros((_GRADIENTS, rows, columns), np.float32)
    half, limit = np.float32(0.5), np.float32(_TRUNCATED_AT)
    for i in range(rows):
        for j in range(columns):
            for n in range(4):
                scale = scales[i + n // 2, j + n % 2]
                texture = np.float32(0)
                for k in range(_DIRECTIONS):
                    share = min(sums[i, j, k] * scale, limit)
                    features[k, i, j] += half * share
                    texture += share
                for k in range(_ORIENTATIONS):
                    share = min((sums[i, j, k] + sums[i, j, k + _ORIENTATIONS]) * scale, limit)
                    features[_DIRECTIONS + k, i, j] += half * share
                features[_DIRECTIONS + _ORIENTATIONS + n, i, j] = np.float32(_TEXTURE_WEIGHT) * texture
    return features
