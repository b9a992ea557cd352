"""Looks of different people: builds of women, men and children, skin and hair that go together, everyday clothes.

Builds of adults are those of Heinz, Peterson, Johnson and Kerk ("Exploring relationships in body dimensions", Journal
of Statistics Education, 2003: 507 adults), relative to the mean of both sexes, which the average ``Figure`` stands for;
waists grow with age. Statures of children are medians of the WHO growth reference (2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np

from sim.checks import check
from sim.meshes.person_parts import RGB, HairStyle, Headwear, Legwear, Pattern, PersonLook
from sim.motion.skeleton import STATURE_M, Figure

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _Sex:
    """Means and standard deviations: stature in metres; breadths and girth as factors of a ``Figure``.

    Biacromial and bitrochanteric breadth and waist girth over stature: 0.2319, 0.1829 and 0.4755 of men, 0.2213, 0.1911
    and 0.4233 of women.
    """

    stature_m: tuple[float, float]
    shoulders: tuple[float, float]
    hips: tuple[float, float]
    waist: tuple[float, float]


_MAN = _Sex((1.777, 0.072), (1.023, 0.040), (0.978, 0.050), (1.059, 0.11))
_WOMAN = _Sex((1.649, 0.065), (0.977, 0.040), (1.022, 0.050), (0.943, 0.11))
_ADULT_AGES = (18.0, 80.0)
_WAIST_A_YEAR, _WAIST_AGE = 0.005, 30.0
"""Growth of the waist's factor from that age on, our choice: the people measured were mostly in their twenties."""
_LEGS_SPREAD = 0.027
"""Sitting height over stature spreads by 0.014, so the length of legs by this share."""
_MIDDLE_M, _HEAD_SLOPE = 1.713, 0.7
"""Stature at which a head is of average size, and how much smaller a part of taller people it is."""

_CHILD_AGES = (6.0, 8.0, 10.0, 12.0, 14.0)
_CHILD_STATURES_M = (1.155, 1.27, 1.38, 1.50, 1.615)
_CHILD_HEADS = (0.93, 0.94, 0.95, 0.97, 0.98)
"""Girth of the head over that of adults, 0.56 m."""
_CHILD_LEGS = (0.94, 0.965, 0.985, 1.0, 1.0)

_SKIN_ITA_DEG = (60.0, 48.0, 34.5, 19.0, -8.0, -50.0)
"""Individual typology angles, ``atan((L* - 50) / b*)``, in the middle of the classes of Chardon, Cretois and Hourseau
(International Journal of Cosmetic Science, 1991): very light, light, intermediate, tan, brown, dark.
"""
_SKIN_A, _SKIN_B = (9.0, 10.0, 11.0, 12.0, 12.0, 9.0), (13.5, 15.0, 17.0, 18.5, 17.0, 12.5)
"""CIELAB a* and b* of these classes, our reading of published ranges."""
_SKIN_SHARES = (0.13, 0.24, 0.23, 0.18, 0.14, 0.08)
_HAIRS_RGB: tuple[RGB, ...] = (
    (178, 142, 92),
    (136, 100, 62),
    (92, 64, 42),
    (138, 74, 42),
    (62, 46, 36),
    (34, 28, 26),
)
_HAIR_SHARES = (
    (0.25, 0.25, 0.20, 0.08, 0.17, 0.05),
    (0.12, 0.22, 0.30, 0.03, 0.23, 0.10),
    (0.02, 0.08, 0.25, 0.01, 0.40, 0.24),
    (0.00, 0.02, 0.10, 0.00, 0.38, 0.50),
    (0.00, 0.00, 0.04, 0.00, 0.26, 0.70),
    (0.00, 0.00, 0.00, 0.00, 0.12, 0.88),
)
"""Shares of blond, light brown, brown, red, dark brown and black hair in each class of skin (Fitzpatrick, Archives of
Dermatology, 1988, describes which go together; the numbers are our choice).
"""
_GREY_RGB = (172, 170, 166)
_GREY_FROM, _GREY_YEARS = 38.0, 45.0
"""Hair turns grey from that age on within so many years (Panhard, Lozano and Loussouarn 2012: about a quarter of it
between 45 and 65).
"""
_DYED_RGB: tuple[RGB, ...] = ((150, 40, 70), (60, 70, 140), (190, 110, 150))

_TOPS_RGB: tuple[RGB, ...] = (
    (34, 34, 38),
    (40, 48, 72),
    (92, 94, 98),
    (216, 214, 208),
    (150, 146, 138),
    (70, 92, 128),
    (128, 40, 44),
    (58, 78, 58),
    (148, 118, 84),
    (176, 60, 52),
    (204, 164, 70),
    (120, 76, 112),
    (96, 136, 160),
    (196, 150, 150),
    (66, 110, 96),
)
_TOP_WEIGHTS = (5, 4, 4, 3, 3, 3, 2, 2, 2, 1, 1, 1, 1, 1, 1)
_LEGS_RGB: tuple[RGB, ...] = (
    (34, 34, 40),
    (46, 56, 84),
    (74, 92, 124),
    (90, 90, 94),
    (150, 134, 106),
    (86, 68, 52),
    (120, 132, 148),
    (96, 44, 52),
)
_LEG_WEIGHTS = (5, 5, 4, 3, 2, 1, 1, 1)
_SHOES_RGB: tuple[RGB, ...] = ((36, 34, 36), (222, 220, 216), (98, 68, 48), (70, 74, 84), (150, 40, 40))
_SHOE_WEIGHTS = (5, 3, 2, 2, 1)
_BAGS_RGB: tuple[RGB, ...] = ((40, 40, 44), (104, 72, 50), (48, 60, 84), (150, 44, 50), (206, 108, 40), (96, 104, 90))
_STOCKINGS_RGB: tuple[RGB, ...] = ((34, 32, 36), (60, 52, 56), (120, 92, 78))
_DYE = 7.0
"""Standard deviation between clothes of one colour, sRGB."""


def draw_person(rng: np.random.Generator, *, children: float = 0.1) -> PersonLook:
    """Draw a person.

    Args:
        children: share of those between 6 and 14 years, in [0, 1].
    """
    check("children", 0 <= children <= 1, "a share in [0, 1]", children)
    is_child, is_man = rng.random() < children, rng.random() < 0.5
    age = float(rng.uniform(*((_CHILD_AGES[0], _CHILD_AGES[-1]) if is_child else _ADULT_AGES)))
    body = _child(age, rng) if is_child else _adult(_MAN if is_man else _WOMAN, age, rng)
    kind = int(rng.choice(len(_SKIN_SHARES), p=_SKIN_SHARES))
    stature_m, build, figure = body
    worn = _one(("", "cap", "beanie", "hat", "scarf"), (78, 9, 6, 4, 0 if is_man or is_child else 8), rng)
    coat = rng.random() < (0.1 if is_child else 0.24)
    inner = rng.random() < 0.25
    backpack = rng.random() < (0.35 if is_child else 0.17)
    bag = not backpack and rng.random() < (0.14 if is_man else 0.28)
    legwear = _legwear(is_man, is_child, rng)
    headwear: Headwear = worn or "cap"  # type: ignore[assignment]
    patterns: tuple[Pattern, ...] = ("plain", "stripes", "check", "band", "print")
    return PersonLook(
        stature_m=stature_m,
        build=build,
        figure=figure,
        skin_rgb=_skin(kind, rng),
        hair_rgb=_hair(kind, age, rng),
        hair_style=_style(is_man, is_child, age, kind, rng),
        beard=is_man and not is_child and rng.random() < 0.33,
        cap_rgb=_dyed(_one(_TOPS_RGB, _TOP_WEIGHTS, rng), rng) if worn else None,
        headwear=headwear,
        top_rgb=_dyed(_one(_TOPS_RGB, _TOP_WEIGHTS, rng), rng),
        top_pattern="plain" if coat else _one(patterns, (66, 11, 8, 6, 9), rng),
        top_length="thigh" if coat else "hip",
        inner_rgb=_dyed(_one(_TOPS_RGB, _TOP_WEIGHTS, rng), rng) if inner else None,
        sleeves="long" if coat or inner or rng.random() < 0.62 else "short",
        legwear=legwear,
        legwear_rgb=_dyed(_one(_LEGS_RGB, _LEG_WEIGHTS, rng), rng),
        stockings_rgb=_one(_STOCKINGS_RGB, (2, 1, 1), rng) if legwear == "skirt" and rng.random() < 0.6 else None,
        shoes_rgb=_one(_SHOES_RGB, _SHOE_WEIGHTS, rng),
        backpack_rgb=_one(_BAGS_RGB, (3, 1, 2, 1, 1, 1), rng) if backpack else None,
        bag_rgb=_one(_BAGS_RGB, (4, 3, 1, 1, 0, 1), rng) if bag else None,
    )


def _adult(sex: _Sex, age: float, rng: np.random.Generator) -> tuple[float, float, Figure]:
    """Draw stature, build and figure."""
    stature_m = _within(rng.normal(*sex.stature_m), 1.42, 2.05)
    older = _WAIST_A_YEAR * max(age - _WAIST_AGE, 0.0)
    # Girths are skewed: half of the people are a little thinner than the mean, and few much stouter.
    waist = _within(
        (sex.waist[0] + older) * float(np.exp(rng.normal(-0.5 * sex.waist[1] ** 2, sex.waist[1]))), 0.8, 1.5
    )
    figure = Figure(
        shoulders=_within(rng.normal(*sex.shoulders), 0.88, 1.14),
        hips=_within(rng.normal(*sex.hips) + 0.25 * (waist - sex.waist[0]), 0.85, 1.22),
        waist=waist,
        belly=_within((0.95 if sex is _MAN else 0.55) * (waist - 1.02), 0.0, 0.5),
        bust=_within(rng.normal(0.26, 0.1), 0.05, 0.55) if sex is _WOMAN else 0.0,
        limbs=_within(rng.normal(1.0, _LEGS_SPREAD), 0.93, 1.06),
        head=_within((_MIDDLE_M / stature_m) ** _HEAD_SLOPE * rng.normal(1.0, 0.02), 0.9, 1.15),
    )
    build = _within(rng.normal(1.0 + 0.3 * (waist - sex.waist[0]), 0.045), 0.86, 1.18)
    return stature_m, build, figure


def _child(age: float, rng: np.random.Generator) -> tuple[float, float, Figure]:
    """Draw stature, build and figure."""
    median_m, head, legs = (
        float(np.interp(age, _CHILD_AGES, values)) for values in (_CHILD_STATURES_M, _CHILD_HEADS, _CHILD_LEGS)
    )
    stature_m = _within(median_m * rng.normal(1.0, 0.045), *STATURE_M)
    waist = _within(1.06 * float(np.exp(rng.normal(0.0, 0.08))), 0.9, 1.4)
    figure = Figure(
        shoulders=_within(rng.normal(0.97, 0.03), 0.88, 1.1),
        hips=_within(rng.normal(0.94, 0.04), 0.85, 1.1),
        waist=waist,
        belly=_within(0.6 * (waist - 1.02), 0.0, 0.4),
        limbs=_within(legs * rng.normal(1.0, 0.02), 0.88, 1.06),
        head=_within(head * _MIDDLE_M / stature_m, 0.9, 1.45),
    )
    return stature_m, _within(rng.normal(0.95, 0.05), 0.84, 1.1), figure


def _skin(kind: int, rng: np.random.Generator) -> RGB:
    """Draw a colour of a class of skin: ``L* = 50 + b* tan(ITA)``."""
    ita, b = np.deg2rad(_SKIN_ITA_DEG[kind] + rng.uniform(-5.5, 5.5)), _SKIN_B[kind] + rng.normal(0.0, 0.8)
    lab = np.array([[[50.0 + b * np.tan(ita), _SKIN_A[kind] + rng.normal(0.0, 0.7), b]]], np.float32)
    red, green, blue = np.clip(np.rint(255.0 * cv2.cvtColor(lab, cv2.COLOR_Lab2RGB)), 0, 255).astype(int).ravel()
    return int(red), int(green), int(blue)


def _hair(kind: int, age: float, rng: np.random.Generator) -> RGB:
    if rng.random() < 0.03:
        return _one(_DYED_RGB, (1, 1, 1), rng)
    own = np.array(_one(_HAIRS_RGB, _HAIR_SHARES[kind], rng)) * rng.uniform(0.85, 1.15)
    grey = _within((age - _GREY_FROM) / _GREY_YEARS, 0.0, 1.0) * rng.uniform(0.3, 1.5)
    red, green, blue = (own + min(grey, 1.0) * (np.array(_GREY_RGB) - own)).astype(int).tolist()
    return red, green, blue


def _style(is_man: bool, is_child: bool, age: float, kind: int, rng: np.random.Generator) -> HairStyle:
    bare = 0.0 if is_child else 40.0 * _within((age - 30.0) / 45.0, 0.0, 1.0)
    curly = 22 if kind >= 4 else 4
    men: dict[HairStyle, float] = {"short": 50, "cropped": 18, "curly": curly, "long": 4, "bun": 2}
    men |= {"receding": 0.7 * bare, "bald": 0.3 * bare + (0 if is_child else 4)}
    women: dict[HairStyle, float] = {"long": 32, "ponytail": 20, "bob": 18, "bun": 13, "short": 8, "curly": curly}
    shares = men if is_man else women
    return _one(tuple(shares), tuple(shares.values()), rng)


def _legwear(is_man: bool, is_child: bool, rng: np.random.Generator) -> Legwear:
    options: tuple[Legwear, ...] = ("trousers", "shorts", "skirt")
    shorts = 30.0 if is_child else 12.0
    return _one(options, (100.0 - shorts, shorts, 0.0 if is_man else 28.0), rng)


def _one(options: Sequence[T], weights: Sequence[float], rng: np.random.Generator) -> T:
    share = np.array(weights, dtype=float)
    return options[int(rng.choice(len(options), p=share / share.sum()))]


def _dyed(rgb: RGB, rng: np.random.Generator) -> RGB:
    red, green, blue = np.clip(np.round(np.array(rgb) + rng.normal(0.0, _DYE, 3)), 0, 255).astype(int).tolist()
    return red, green, blue


def _within(value: float, low: float, high: float) -> float:
    return float(min(max(value, low), high))
