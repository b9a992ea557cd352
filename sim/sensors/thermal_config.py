"""Configuration and output of an uncooled thermal camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.checks import check_types, check_within


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

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "rate_hz shutter_every_s settling_s largest_gain", 0, above=True)
        check_within(self, "blur_px", 0, 0.7)
        check_within(self, "netd_k fixed_pattern_k drift_k bowl_k level_k shutter_s", 0)
        check_within(self, "gain_spread linear", 0, 0.5)
        check_within(self, "plateau", 0, 1, above=True)


@dataclass(frozen=True, slots=True)
class ThermalSettings:
    """Settings of one picture.

    Attributes:
        gain: grey levels per kelvin, mean over the middle half of the picture.
        tone: (4096,) float32, the grey level of each four counts.
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
