"""Size, colours and markings of a fish."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.checks import check, check_types, check_within

RGB = tuple[int, int, int]

_LENGTH_SPREAD, _WIDTH_SPREAD = 0.07, 0.06
"""Standard deviations among adults of one age, as shares; our choice, as are all below."""
_SHADE_SPREAD, _HUE_SPREAD = 0.16, 0.02
_STRIPE_SPREAD = 0.12
_MOST_SPOTS = 4


@dataclass(frozen=True, slots=True)
class FishLook:
    """One fish's size, colours (sRGB 0-255) and markings.

    Attributes:
        length_m: from snout to the end of the tail fin, within [0.01, 0.3].
        width: factor of the body's width, within [0.8, 1.25].
        back_rgb, flank_rgb: the back is the darker one.
        fin_rgb: of fins, which are clear in truth and take a little of the floor's colour.
        stripes: contrast of the stripes along the flanks, within [0, 1].
        spots: dark spots on the back, as (place behind the snout as a share of length, darkness in [0, 1]).
    """

    length_m: float = 0.035
    width: float = 1.0
    back_rgb: RGB = (74, 70, 58)
    flank_rgb: RGB = (150, 150, 140)
    fin_rgb: RGB = (128, 124, 108)
    stripes: float = 0.45
    spots: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        """Check sizes and colours.

        Raises:
            ValueError: for an impossible one.
        """
        check_types(self)
        check_within(self, "length_m", 0.01, 0.3)
        check_within(self, "width", 0.8, 1.25)
        check_within(self, "stripes", 0.0, 1.0)
        for name in ("back_rgb", "flank_rgb", "fin_rgb"):
            rgb = getattr(self, name)
            check(name, all(0 <= c <= 255 for c in rgb), "three numbers from 0 to 255", rgb)
        for spot in self.spots:
            check("spots", len(spot) == 2 and all(0 <= part <= 1 for part in spot), "pairs within [0, 1]", spot)


def draw_look(rng: np.random.Generator, variety: float) -> FishLook:
    """Return the look of one fish of a shoal.

    Args:
        rng: draws the same number of values whatever the variety.
        variety: 0 = all fish look the same; 1 = they differ in size, shade, stripes and spots as adults of one strain.

    Raises:
        ValueError: for a variety outside [0, 1].
    """
    check("variety", 0.0 <= variety <= 1.0, "a number in [0, 1]", variety)
    mean = FishLook()
    length, width, shade, stripes = variety * np.clip(rng.normal(size=4), -2.0, 2.0)
    hue = 1.0 + variety * _HUE_SPREAD * np.clip(rng.normal(size=3), -2.0, 2.0)
    count = round(variety * _MOST_SPOTS * float(rng.random()))
    places, darkness = rng.uniform(0.25, 0.75, _MOST_SPOTS), rng.uniform(0.3, 0.8, _MOST_SPOTS)
    light = np.exp(_SHADE_SPREAD * shade)
    return FishLook(
        length_m=mean.length_m * float(np.exp(_LENGTH_SPREAD * length)),
        width=float(np.clip(mean.width * (1.0 + _WIDTH_SPREAD * width), 0.8, 1.25)),
        back_rgb=_tinted(mean.back_rgb, light * hue),
        flank_rgb=_tinted(mean.flank_rgb, np.sqrt(light) * hue),
        fin_rgb=mean.fin_rgb,
        stripes=float(np.clip(mean.stripes + _STRIPE_SPREAD * stripes, 0.0, 1.0)),
        spots=tuple((float(p), float(d)) for p, d in zip(places[:count], darkness[:count], strict=True)),
    )


def _tinted(rgb: RGB, factor: object) -> RGB:
    red, green, blue = np.clip(np.rint(np.array(rgb) * factor), 0, 255).astype(int).tolist()
    return red, green, blue
