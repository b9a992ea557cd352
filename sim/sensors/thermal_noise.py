"""From radiance to 14-bit counts: blur, fixed pattern and noise of a microbolometer.

    blurred  b = [a, 1 - 2 a, a] along rows and columns, 2 a = blur²
    count      = clip(round((b (1 + g) + o + age d + noise n - lowest) / step), 0, 16383),   n ~ N(0, 1)

g, o and d belong to the pixel: spread of responsivity, pattern left by the latest correction, and drift since.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.sensors.noise import NORMAL, TEN_BITS, hash_row

LARGEST_COUNT = (1 << 14) - 1
_HALF, _ZERO, _ONE = np.float32(0.5), np.float32(0.0), np.float32(1.0)
_LARGEST = np.float32(LARGEST_COUNT)


class Bolometers(NamedTuple):
    """Pixels at one time, all float32.

    Attributes:
        gain: (H, W), g. offset, drift: (H, W) radiance, o and d.
        age: share of the time between corrections that has passed.
        noise: standard deviation of radiance. side: a, the neighbours' share of the blur.
        lowest: radiance of count 0. per_radiance: counts.
    """

    gain: NDArray[np.float32]
    offset: NDArray[np.float32]
    drift: NDArray[np.float32]
    age: np.float32
    noise: np.float32
    side: np.float32
    lowest: np.float32
    per_radiance: np.float32


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def count_picture(
    radiance: NDArray[np.float32],
    pixels: Bolometers,
    keys: NDArray[np.uint32],
    hashes: NDArray[np.uint32],
    lines: NDArray[np.float32],
    counts: NDArray[np.uint16],
) -> None:
    """Write the counts (H, W) of a picture (H, W).

    Args:
        keys: (2,), see ``sim.sensors.noise.frame_keys``.
        hashes: (W,) scratch. lines: (2, W + 2) scratch.
    """
    height, width = radiance.shape
    side, centre = pixels.side, _ONE - np.float32(2.0) * pixels.side
    down, noise = lines[0], lines[1]
    for row in range(height):
        above, here, below = radiance[max(row - 1, 0)], radiance[row], radiance[min(row + 1, height - 1)]
        for k in range(width):
            down[k + 1] = centre * here[k] + side * (above[k] + below[k])
        down[0], down[width + 1] = down[1], down[width]
        hash_row(keys, row, hashes)
        for k in range(width):
            noise[k] = NORMAL[hashes[k] & TEN_BITS]
        gain, offset, drift, line = pixels.gain[row], pixels.offset[row], pixels.drift[row], counts[row]
        for k in range(width):
            blurred = centre * down[k + 1] + side * (down[k] + down[k + 2])
            read = blurred * (_ONE + gain[k]) + offset[k] + pixels.age * drift[k] + pixels.noise * noise[k]
            count = (read - pixels.lowest) * pixels.per_radiance + _HALF
            line[k] = np.uint16(np.int32(min(max(count, _ZERO), _LARGEST)))


@row_kernel()
def fill_deviates(keys: NDArray[np.uint32], hashes: NDArray[np.uint32], deviates: NDArray[np.float32]) -> None:
    """Write values of N(0, 1) for the pixels of a pattern (H, W); ``hashes`` (W,) is scratch."""
    for row in range(deviates.shape[0]):
        hash_row(keys, row, hashes)
        for k in range(deviates.shape[1]):
            deviates[row, k] = NORMAL[hashes[k] & TEN_BITS]
