"""From radiance to codes, with light that the lens scatters and the noise of photons and of the read-out.

    electrons  e  = L * electrons_per_nit_s * exposure
    noisy      e' = min(e + sqrt(e + read_noise²) * n, full_well),   n ~ N(0, 1)
    12 bits    d  = clip(round(4095 * e' * gain * colour gain / full_well), 0, 4095)
    8 bits        = round(255 * sRGB(d / 4095))

Photon counts are Poisson; with the electrons of daylight the normal distribution of the same mean and
variance is indistinguishable. ``n`` is counter-based: a function of (key, frame, pixel, channel) alone, so
a picture's noise does not depend on what was drawn before it. Of one well-mixed 32-bit number, ten bits for
each channel pick one of 1,024 equally likely values of the normal distribution, of mean 0 and variance 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import ndtri

from sim.render.compilation import row_kernel
from sim.sensors.automatic import channel_gains
from sim.sensors.config import SensorConfig, SensorSettings
from sim.shaders.colour import linear_to_srgb


def veil(metered: NDArray[np.float64], share: float) -> NDArray[np.float32]:
    """Return the light (3,) that lens and housing spread evenly over a picture, given its mean radiance (3,).

    A share of all light is scattered (veiling glare, ISO 9358): ``L' = (1 - share) L + share mean(L)``, of which this
    is the last part.
    """
    return (share * metered).astype(np.float32)


@row_kernel()
def scatter_row(
    radiance: NDArray[np.float32], share: np.float32, veil: NDArray[np.float32], scattered: NDArray[np.float32]
) -> None:
    """Write ``(1 - share) L + veil`` of one row (3, W)."""
    kept = np.float32(1.0) - share
    for channel in range(3):
        line, into, more = radiance[channel], scattered[channel], veil[channel]
        for k in range(line.shape[0]):
            into[k] = kept * line[k] + more


WHITE = 4095
CODES = np.round(255.0 * linear_to_srgb(np.arange(WHITE + 1) / WHITE)).astype(np.uint8)
"""8-bit code of each 12-bit value."""

_QUANTILES = ndtri((np.arange(1024) + 0.5) / 1024)
NORMAL = (_QUANTILES / _QUANTILES.std()).astype(np.float32)

TEN_BITS = np.uint32(1023)
MIX_1, MIX_2 = np.uint32(0x7FEB352D), np.uint32(0x846CA68B)
_WORD = (1 << 32) - 1


def frame_keys(key: int, frame: int) -> NDArray[np.uint32]:
    """Return the two 32-bit keys (2,) of one frame's noise: two steps of splitmix64 from ``key`` and
    ``frame``.
    """
    mask = (1 << 64) - 1
    state = (key + (2 * frame + 1) * 0x9E3779B97F4A7C15) & mask
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & mask
    state ^= state >> 31
    return np.array([state & _WORD, state >> 32], dtype=np.uint32)


def response(config: SensorConfig, settings: SensorSettings) -> NDArray[np.float32]:
    """Return what the kernel needs (6,): electrons per cd/m², full well, read-noise variance, and 12-bit values per
    electron of each channel.
    """
    gains = channel_gains(settings.red_gain, settings.blue_gain)
    per_electron = [WHITE * settings.gain * gain / config.full_well_e for gain in gains]
    return np.array(
        [config.electrons_per_nit_s * settings.exposure_s, config.full_well_e, config.read_noise_e**2, *per_electron],
        dtype=np.float32,
    )


class Development(NamedTuple):
    """What becomes of a picture's radiance.

    Attributes:
        share: of the light that is scattered. veil: (3,) float32, see ``veil``.
        response: (6,), see ``response``. keys: (2,), see ``frame_keys``.
        image_rgb: (H, W, 3) uint8, written.
    """

    share: np.float32
    veil: NDArray[np.float32]
    response: NDArray[np.float32]
    keys: NDArray[np.uint32]
    image_rgb: NDArray[np.uint8]


class DevelopScratch(NamedTuple):
    """Scratch of ``develop_row``: light and noise (3, W) float32, hashes (W,), 12-bit values (3, W) uint16."""

    light: NDArray[np.float32]
    noise: NDArray[np.float32]
    hashes: NDArray[np.uint32]
    values: NDArray[np.uint16]


@njit(cache=True)
def new_develop_scratch(width: int) -> DevelopScratch:
    """Return scratch for rows of ``width`` pixels."""
    light, noise = np.empty((3, width), np.float32), np.empty((3, width), np.float32)
    return DevelopScratch(light, noise, np.empty(width, np.uint32), np.empty((3, width), np.uint16))


@njit(cache=True)
def develop_rows(radiance: NDArray[np.float32], rows: NDArray[np.int64], development: Development) -> None:
    """Write the given rows (R,) of the picture from their radiance (R, 3, W)."""
    scratch = new_develop_scratch(radiance.shape[2])
    for k in range(rows.shape[0]):
        develop_row(development, rows[k], scratch, radiance[k])


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def develop_row(development: Development, row: int, scratch: DevelopScratch, radiance: NDArray[np.float32]) -> None:
    """Write one row of the picture from its radiance (3, W)."""
    per_nit, full_well, read_variance = development.response[0], development.response[1], development.response[2]
    image, noise, values = development.image_rgb[row], scratch.noise, scratch.values
    zero, half, white = np.float32(0.0), np.float32(0.5), np.float32(WHITE)
    width = radiance.shape[1]
    scattered = radiance
    if development.share > zero:
        scatter_row(radiance, development.share, development.veil, scratch.light)
        scattered = scratch.light
    normal_deviates(development.keys, row, scratch.hashes, noise)
    for channel in range(3):
        light, n, value, per_electron = (
            scattered[channel],
            noise[channel],
            values[channel],
            development.response[3 + channel],
        )
        for k in range(width):
            e = light[k] * per_nit
            e = min(e + np.sqrt(e + read_variance) * n[k], full_well)
            value[k] = np.uint16(np.int32(min(max(e * per_electron + half, zero), white)))
    for k in range(width):
        for channel in range(3):
            image[k, channel] = CODES[values[channel, k]]


@row_kernel()
def normal_deviates(
    keys: NDArray[np.uint32], row: int, hashes: NDArray[np.uint32], deviates: NDArray[np.float32]
) -> None:
    """Write one row (3, W) of values of N(0, 1), and the numbers (W,) that pick them, see ``hash_row``."""
    hash_row(keys, row, hashes)
    for k in range(deviates.shape[1]):
        h = hashes[k]
        deviates[0, k] = NORMAL[h & TEN_BITS]
        deviates[1, k] = NORMAL[(h >> np.uint32(10)) & TEN_BITS]
        deviates[2, k] = NORMAL[(h >> np.uint32(20)) & TEN_BITS]


@row_kernel()
def hash_row(keys: NDArray[np.uint32], row: int, hashes: NDArray[np.uint32]) -> None:
    """Write a well-mixed number for each pixel of a row (W,): Wellons' ``lowbias32`` of ``pixel + keys[0]``, with
    ``keys[1]`` mixed in between its rounds.
    """
    width = hashes.shape[0]
    first = np.uint32(np.uint32(row * width) + keys[0])
    second = keys[1]
    for k in range(width):
        h = np.uint32(np.uint32(k) + first)
        h = np.uint32(np.uint32(h ^ np.uint32(h >> np.uint32(16))) * MIX_1)
        h = np.uint32(h ^ second)
        h = np.uint32(np.uint32(h ^ np.uint32(h >> np.uint32(15))) * MIX_2)
        hashes[k] = np.uint32(h ^ np.uint32(h >> np.uint32(16)))
