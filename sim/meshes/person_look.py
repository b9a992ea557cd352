"""Size, colours and clothes of a person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sim.checks import check
from sim.motion.skeleton import skeleton

RGB = tuple[int, int, int]
HAIR_STYLES = ("short", "long")
PATTERNS = ("plain", "stripes", "check")


@dataclass(frozen=True, slots=True)
class PersonLook:
    """One person's size, colours (sRGB 0-255) and clothes.

    Attributes:
        stature_m: within ``STATURE_M`` of ``sim.motion.skeleton``.
        build: factor of girths within ``BUILD`` there.
        hair_style: long hair reaches the shoulders.
        cap_rgb: of a cap worn over it, None for no cap.
        top_pattern: horizontal stripes or a check in a darker shade of the top.
        sleeves: short ones end above the elbow.
        legwear: shorts end at the knee.
        backpack_rgb: None for no backpack.
    """

    stature_m: float = 1.74
    build: float = 1.0
    skin_rgb: RGB = (204, 158, 130)
    hair_rgb: RGB = (62, 46, 36)
    hair_style: Literal["short", "long"] = "short"
    cap_rgb: RGB | None = None
    top_rgb: RGB = (70, 92, 128)
    top_pattern: Literal["plain", "stripes", "check"] = "plain"
    sleeves: Literal["long", "short"] = "long"
    legwear: Literal["trousers", "shorts"] = "trousers"
    legwear_rgb: RGB = (52, 56, 70)
    shoes_rgb: RGB = (44, 42, 44)
    backpack_rgb: RGB | None = None

    def __post_init__(self) -> None:
        """Check sizes and words.

        Raises:
            ValueError: for an impossible size or an unknown word.
        """
        skeleton(self.stature_m, self.build)
        for name in ("skin", "hair", "cap", "top", "legwear", "shoes", "backpack"):
            rgb = getattr(self, f"{name}_rgb")
            good = rgb is None or (len(rgb) == 3 and all(0 <= c <= 255 for c in rgb))
            check(f"{name}_rgb", good, "three numbers from 0 to 255", rgb)
        check("hair_style", self.hair_style in HAIR_STYLES, f"one of {HAIR_STYLES}", self.hair_style)
        check("top_pattern", self.top_pattern in PATTERNS, f"one of {PATTERNS}", self.top_pattern)
        check("sleeves", self.sleeves in ("long", "short"), "long or short", self.sleeves)
        check("legwear", self.legwear in ("trousers", "shorts"), "trousers or shorts", self.legwear)
