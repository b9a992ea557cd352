"""Configuration and settings of a camera's sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim.checks import check


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """A colour sensor of a small machine-vision camera.

    Attributes:
        white_balance: ``auto`` (white-balance loop) or ``off`` (gains of 1).
        shortest_exposure_s, longest_exposure_s: range of the loop; the gain rises only at the longest.
        largest_gain: largest gain of the loop, the smallest is 1.
        mid_grey: linear level in (0, 1) to which the loop brings the mean luminance of the picture.
        largest_colour_gain: red and blue are multiplied by no more than this, and by no less than its inverse.
        adaptation: share in (0, 1] of the (logarithmic) way to the right exposure and white balance done from one
            frame to the next.
        veiling_glare: share in [0, 1) of all light that lens and housing scatter evenly over the picture, which makes
            colours pale in back light.
        electrons_per_nit_s: electrons in a pixel per cd/m² and second of exposure; 900 is about that of a 3.45 µm
            pixel behind a lens at f/2.8.
        full_well_e: electrons at which a pixel is full; at gain g the picture is white at ``full_well_e /
            g``.
        read_noise_e: standard deviation of the read-out, electrons.
    """

    white_balance: Literal["auto", "off"] = "off"
    shortest_exposure_s: float = 2e-5
    longest_exposure_s: float = 4e-3
    largest_gain: float = 16.0
    largest_colour_gain: float = 4.0
    mid_grey: float = 0.18
    adaptation: float = 0.4
    veiling_glare: float = 0.0
    electrons_per_nit_s: float = 900.0
    full_well_e: float = 10_500.0
    read_noise_e: float = 7.0

    def __post_init__(self) -> None:
        for name in ("shortest_exposure_s", "electrons_per_nit_s", "full_well_e"):
            check(name, getattr(self, name) > 0, "a number > 0", getattr(self, name))
        check("white_balance", self.white_balance in ("auto", "off"), "'auto' or 'off'", self.white_balance)
        check(
            "longest_exposure_s",
            self.longest_exposure_s >= self.shortest_exposure_s,
            f"at least shortest_exposure_s = {self.shortest_exposure_s}",
            self.longest_exposure_s,
        )
        check("largest_gain", self.largest_gain >= 1, "a number >= 1", self.largest_gain)
        check("largest_colour_gain", self.largest_colour_gain >= 1, "a number >= 1", self.largest_colour_gain)
        check("mid_grey", 0 < self.mid_grey < 1, "a number in (0, 1)", self.mid_grey)
        check("adaptation", 0 < self.adaptation <= 1, "a number in (0, 1]", self.adaptation)
        check("veiling_glare", 0 <= self.veiling_glare < 1, "a number in [0, 1)", self.veiling_glare)
        check("read_noise_e", self.read_noise_e >= 0, "a number >= 0", self.read_noise_e)


@dataclass(frozen=True, slots=True)
class SensorSettings:
    """Settings of one exposure.

    Attributes:
        exposure_s: exposure time.
        gain: 1 = none.
        red_gain, blue_gain: of these channels relative to green, 1 = none: the white balance.
    """

    exposure_s: float
    gain: float
    red_gain: float = 1.0
    blue_gain: float = 1.0


@dataclass(frozen=True, slots=True)
class Picture:
    """Output of the sensor.

    Attributes:
        image_rgb: (H, W, 3) uint8, sRGB encoded.
        settings: in use for this picture.
    """

    image_rgb: NDArray[np.uint8]
    settings: SensorSettings
