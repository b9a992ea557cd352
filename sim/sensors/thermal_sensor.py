"""An uncooled thermal camera: from radiance in its band to counts, and by its gain control to the 8 bits that it shows.

Plateau equalisation (Vickers, "Plateau equalization algorithm for real-time display of high-quality infrared imagery",
Optical Engineering 35, 1996): grey levels are shared out by the histogram, of which no count gets more than a plateau,
so that wide, even surfaces leave levels to the rest. A share of the levels is spread evenly over the range in use. No
step is steeper than the largest gain. The curve in use follows at a rate of its own.

    blurred  b = [a, 1 - 2 a, a] along rows and columns, 2 a = blur²
    count      = clip(round((b (1 + g) + o + age d + noise n - lowest) / step), 0, 16383),   n ~ N(0, 1)

g, o and d belong to the pixel: spread of responsivity, pattern left by the latest correction, and drift since.

Noise and pattern depend on the frame alone, whatever was taken before it; the gain control has a memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.checks import check_types, check_within
from sim.optics import Camera, CameraMotion
from sim.render.compilation import announce_compilation, row_kernel
from sim.sensors.local_contrast import HEADROOM, show_detail
from sim.sensors.noise import NORMAL, TEN_BITS, frame_keys, hash_row
from sim.thermal.radiance import apparent_temperature_k, band_radiance, band_slope


@dataclass(frozen=True, slots=True)
class ThermalConfig:
    """An uncooled microbolometer camera for 8 to 14 µm. Kelvins are those of a black body of about 300 K.

    Attributes:
        rate_hz: of its pictures.
        blur_px: standard deviation of the blur by optics and pixel, in [0, 0.7].
        netd_k: standard deviation of the noise from picture to picture.
        fixed_pattern_k: of the fixed pattern that a correction leaves.
        drift_k: of what the pattern gains until the next correction, a quarter of it in columns.
        bowl_k: by how much the corners drift from the middle until then, as the housing warms.
        level_k: standard deviation of the step of the whole picture at a correction.
        gain_spread: standard deviation of the pixels' responsivities.
        shutter_every_s: time between corrections. shutter_s: for so long the picture is held meanwhile.
        plateau: share of a picture that one count in the histogram of the gain control stands for at most.
        linear: share of the grey levels that the gain control spreads evenly over the range, whatever is there.
        largest_gain: grey levels per kelvin.
        settling_s: time constant of the gain control.
        detail: grey levels per kelvin of small differences, see ``sim.sensors.local_contrast``, or as many as the curve
            has if these are more; never more than ``largest_gain``. 0: one curve for the whole picture.
    """

    rate_hz: float = 0.5
    blur_px: float = 0.55
    netd_k: float = 0.06
    fixed_pattern_k: float = 0.025
    drift_k: float = 0.08
    bowl_k: float = 0.25
    level_k: float = 0.15
    gain_spread: float = 0.003
    shutter_every_s: float = 180.0
    shutter_s: float = 0.8
    plateau: float = 0.004
    linear: float = 0.25
    largest_gain: float = 30.0
    settling_s: float = 4.0
    detail: float = 0.0

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "rate_hz shutter_every_s settling_s largest_gain", 0, above=True)
        check_within(self, "blur_px", 0, 0.7)
        check_within(self, "netd_k fixed_pattern_k drift_k bowl_k level_k shutter_s detail", 0)
        check_within(self, "gain_spread linear", 0, 0.5)
        check_within(self, "plateau", 0, 1, above=True)


@dataclass(frozen=True, slots=True)
class ThermalSettings:
    """Settings of one picture.

    Attributes:
        gain: grey levels per kelvin of ``tone``, mean over the middle half of the picture. With ``detail`` small
            differences are shown at more.
        tone: (4096,) float32, the grey level of each four counts; with ``detail``, of the base alone.
        is_held: True for a picture that is that before, as the shutter was closed.
        has_stepped: True if the shutter corrected the pattern since the last picture, or the gain control changed grey
            levels at once.
        exposure_s: a bolometer has none.
    """

    gain: float
    tone: NDArray[np.float32]
    is_held: bool = False
    has_stepped: bool = False
    exposure_s: float = 0.0


@dataclass(frozen=True, slots=True)
class ThermalPicture:
    """Output of the sensor.

    Attributes:
        image_rgb: (H, W, 3) uint8, grey, a view of one array.
        counts: (H, W) uint16, 14 bits.
        radiance: (H, W) float32, what came in: W/(m² sr), without blur and noise.
        settings: in use for this picture.
    """

    image_rgb: NDArray[np.uint8]
    counts: NDArray[np.uint16]
    radiance: NDArray[np.float32]
    settings: ThermalSettings


BIN_COUNTS = 4
BINS = (1 << 14) // BIN_COUNTS
SAMPLED = 2
"""Every second pixel of every second row is in the histogram."""
_OUTLIERS = 0.001
"""Share of the picture beyond either end of the range."""
_WHITE = 255.0


@njit(cache=True)
def histogram(counts: NDArray[np.uint16]) -> NDArray[np.int64]:
    """Return how many of the sampled pixels are in each bin (BINS,)."""
    found = np.zeros(BINS, np.int64)
    for row in range(0, counts.shape[0], SAMPLED):
        for column in range(0, counts.shape[1], SAMPLED):
            found[counts[row, column] // BIN_COUNTS] += 1
    return found


@njit(cache=True)
def right_tone(found: NDArray[np.int64], plateau: float, linear: float, largest_per_bin: float) -> NDArray[np.float32]:
    """Return the grey level (BINS,) of each bin that fits a histogram.

    Args:
        plateau: share of the picture that a bin may stand for at most.
        linear: share of the levels that are spread evenly.
        largest_per_bin: greatest step from one bin to the next.
    """
    total = found.sum()
    first, last = bin_at(found, _OUTLIERS), bin_at(found, 1.0 - _OUTLIERS)
    most, counted = max(plateau * total, 1.0), 0.0
    for k in range(first, last + 1):
        counted += min(float(found[k]), most)
    tone, even, used = np.zeros(found.shape[0]), linear / (last + 1 - first), 0.0
    for k in range(first, last + 1):
        share = (1.0 - linear) * min(float(found[k]), most) / counted + even
        step = min(_WHITE * share, largest_per_bin)
        tone[k] = used + 0.5 * step
        used += step
    tone[last + 1 :] = used
    # Where the largest gain leaves levels over, the picture lies in the middle of them.
    return (tone + 0.5 * (_WHITE - used)).astype(np.float32)


@njit(cache=True)
def bin_at(found: NDArray[np.int64], share: float) -> int:
    """Return the bin in which a share of a histogram is reached."""
    wanted, below = share * found.sum(), 0
    for k in range(found.shape[0]):
        below += found[k]
        if below >= wanted:
            return k
    return found.shape[0] - 1


@njit(cache=True)
def apply_tone(counts: NDArray[np.uint16], grey_of_bin: NDArray[np.uint8], grey: NDArray[np.uint8]) -> None:
    """Write the grey level (H, W) of each count (H, W)."""
    for row in range(counts.shape[0]):
        for column in range(counts.shape[1]):
            grey[row, column] = grey_of_bin[counts[row, column] // BIN_COUNTS]


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


REFERENCE_K = 300.0
RANGE_K = (233.0, 423.0)
"""Black bodies of count 0 and of the largest count: the usual range of high gain."""
STEP_GREY = 6.0
"""The gain control has stepped if it changes the grey level of a picture's pixels by more than this on average."""

_LOWEST, _HIGHEST = (float(band_radiance(kelvin)) for kelvin in RANGE_K)
PER_RADIANCE = LARGEST_COUNT / (_HIGHEST - _LOWEST)
_PER_K = float(band_slope(REFERENCE_K))
_GAIN, _DRIFT, _COLUMNS, _LEVEL, _RESIDUE = range(5)
"""Patterns of a sensor, by number; residues of later corrections follow."""


class ThermalSensor:
    """A ``Sensor`` of one band, see ``sim.render.pipeline``. Its gain control is settled at the first picture."""

    def __init__(
        self, config: ThermalConfig, rng: np.random.Generator, noise_rng: np.random.Generator | None = None
    ) -> None:
        """Draw the keys of all noise to come, and the time of the first correction, from ``rng``.

        Args:
            noise_rng: of the noise from picture to picture, where another sensor of the same ``rng`` takes pictures of
                the same numbers with the same pattern.
        """
        self.config = config
        self._noise_key, self._pattern_key = (int(key) for key in rng.integers(1 << 63, size=2))
        if noise_rng is not None:
            self._noise_key = int(noise_rng.integers(1 << 63))
        self._phase = float(rng.uniform())
        self._warming = float(rng.choice([-1.0, 1.0]))
        self._patterns: dict[tuple[int, int, int], tuple[NDArray[np.float32], ...]] = {}
        self._tone: NDArray[np.float32] | None = None
        self._latest: ThermalPicture | None = None
        self._frame = self._adapted_at = -1
        announce_compilation(count_picture)

    def expose(
        self, radiance: NDArray[np.float32], camera: Camera, frame: int, motion: CameraMotion | None = None
    ) -> ThermalPicture:
        """Take the picture of a frame from its radiance (H, 1, W) in W/(m² sr), see ``Sensor``.

        Frames may be left out: the gain control then settles for longer.
        """
        is_next, self._frame = frame == self._frame + 1, frame
        if self._latest is not None and is_next and self._is_closed(frame):
            held = self._latest
            settings = ThermalSettings(held.settings.gain, held.settings.tone, is_held=True)
            return ThermalPicture(held.image_rgb, held.counts, radiance[:, 0], settings)
        counts = self._counts(radiance[:, 0], frame)
        settings = self._adapted(counts, frame)
        self._latest = self._toned(radiance, counts, settings)
        return self._latest

    def develop(
        self,
        radiance: NDArray[np.float32],
        camera: Camera,
        frame: int,
        settings: ThermalSettings,
        motion: CameraMotion | None = None,
    ) -> ThermalPicture:
        """Take a picture with given settings; the gain control stays as it is. Arguments as for ``expose``."""
        return self._toned(radiance, self._counts(radiance[:, 0], frame), settings)

    def _corrections(self, frame: int) -> float:
        """Return how many intervals between corrections have passed; the first one began before the first frame."""
        return frame / (self.config.rate_hz * self.config.shutter_every_s) + self._phase

    def _is_closed(self, frame: int) -> bool:
        """Return whether the shutter is closed."""
        return self._corrections(frame) % 1.0 < self.config.shutter_s / self.config.shutter_every_s

    def _counts(self, radiance: NDArray[np.float32], frame: int) -> NDArray[np.uint16]:
        c = self.config
        passed = self._corrections(frame)
        gain, drift, offset = self._pattern(int(np.floor(passed)), *radiance.shape)
        pixels = Bolometers(
            gain,
            offset,
            drift,
            np.float32(passed % 1.0),
            np.float32(c.netd_k * _PER_K),
            np.float32(0.5 * c.blur_px**2),
            np.float32(_LOWEST),
            np.float32(PER_RADIANCE),
        )
        width = radiance.shape[1]
        counts = np.empty(radiance.shape, np.uint16)
        hashes, lines = np.empty(width, np.uint32), np.empty((2, width + 2), np.float32)
        count_picture(radiance, pixels, frame_keys(self._noise_key, frame), hashes, lines, counts)
        return counts

    def _pattern(self, correction: int, height: int, width: int) -> tuple[NDArray[np.float32], ...]:
        """Return gain, drift and offset (H, W) between a correction and the next."""
        key = correction, height, width
        if key not in self._patterns:
            # The larger view's pattern is kept beside the picture's.
            self._patterns = dict([*self._patterns.items()][-1:])
            c = self.config
            gain = c.gain_spread * self._deviates(_GAIN, height, width)
            columns = self._deviates(_COLUMNS, 1, width)
            drift = c.drift_k * (np.sqrt(0.75) * self._deviates(_DRIFT, height, width) + 0.5 * columns)
            drift += self._warming * c.bowl_k * _bowl(height, width)
            residue = c.fixed_pattern_k * self._deviates(_RESIDUE + correction, height, width)
            residue += c.level_k * self._deviates(_LEVEL, 1, correction + 1)[0, correction]
            self._patterns[key] = tuple(
                np.asarray(each, np.float32) for each in (gain, _PER_K * drift, _PER_K * residue)
            )
        return self._patterns[key]

    def _deviates(self, number: int, height: int, width: int) -> NDArray[np.float32]:
        """Return the values (H, W) of one of the sensor's patterns, of N(0, 1)."""
        deviates = np.empty((height, width), np.float32)
        fill_deviates(frame_keys(self._pattern_key, number), np.empty(width, np.uint32), deviates)
        return deviates

    def _right_tone(self, found: NDArray[np.int64]) -> NDArray[np.float32]:
        c = self.config
        largest = c.largest_gain * BIN_COUNTS / (PER_RADIANCE * _PER_K)
        tone = right_tone(found, c.plateau, c.linear, largest)
        return tone if c.detail == 0.0 else np.float32(HEADROOM) + tone * np.float32(1.0 - 2.0 * HEADROOM / _WHITE)

    def _adapted(self, counts: NDArray[np.uint16], frame: int) -> ThermalSettings:
        """Let the gain control take its step and return the settings that follow."""
        found = histogram(counts)
        right = self._right_tone(found)
        has_stepped = False
        if self._tone is None:
            self._tone = right
        else:
            passed_s = max(frame - self._adapted_at, 1) / self.config.rate_hz
            change = np.float32(1.0 - np.exp(-passed_s / self.config.settling_s)) * (right - self._tone)
            corrected = int(self._corrections(frame)) != int(self._corrections(self._adapted_at))
            has_stepped = corrected or float(np.abs(change) @ found / found.sum()) > STEP_GREY
            self._tone = self._tone + change
        self._adapted_at = frame
        return ThermalSettings(_gain(self._tone, found), self._tone, has_stepped=has_stepped)

    def _toned(
        self, radiance: NDArray[np.float32], counts: NDArray[np.uint16], settings: ThermalSettings
    ) -> ThermalPicture:
        grey = np.empty(counts.shape, np.uint8)
        if self.config.detail > 0.0:
            grey_per_k = min(max(self.config.detail, settings.gain), self.config.largest_gain)
            show_detail(counts, settings.tone, grey_per_k / (PER_RADIANCE * _PER_K), PER_RADIANCE * _PER_K, grey)
        else:
            apply_tone(counts, np.round(settings.tone).astype(np.uint8), grey)
        return ThermalPicture(np.broadcast_to(grey[..., None], (*grey.shape, 3)), counts, radiance[:, 0], settings)


def _gain(tone: NDArray[np.float32], found: NDArray[np.int64]) -> float:
    """Return the grey levels per kelvin over the middle half of a histogram."""
    low = bin_at(found, 0.25)
    high = max(bin_at(found, 0.75), low + 1)
    low_k, high_k = apparent_temperature_k(_LOWEST + np.array([low, high]) * BIN_COUNTS / PER_RADIANCE)
    return float((tone[high] - tone[low]) / (high_k - low_k))


def _bowl(height: int, width: int) -> NDArray[np.float64]:
    """Return how far each pixel (H, W) is on the way from the middle (-1/3) to the corners (2/3), squared."""
    rows, columns = ((np.arange(side) + 0.5) / (0.5 * side) - 1.0 for side in (height, width))
    away: NDArray[np.float64] = 0.5 * (rows[:, None] ** 2 + columns**2) - 1.0 / 3.0
    return away
