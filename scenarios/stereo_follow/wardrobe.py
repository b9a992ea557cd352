"""Clothes of people; some are dressed like the target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim.meshes.person import RGB, PersonLook

_TOPS_RGB: tuple[RGB, ...] = (
    (70, 92, 128),
    (168, 46, 44),
    (52, 96, 70),
    (196, 186, 168),
    (60, 60, 66),
    (206, 160, 60),
    (120, 70, 110),
    (92, 128, 156),
    (150, 96, 62),
    (226, 224, 218),
    (36, 52, 92),
    (110, 116, 84),
)
_LEGWEAR_RGB: tuple[RGB, ...] = ((52, 56, 70), (40, 40, 44), (62, 76, 110), (126, 110, 84), (92, 94, 98), (88, 70, 56))
_SKIN_RGB: tuple[RGB, ...] = ((224, 182, 154), (204, 158, 130), (176, 128, 98), (132, 92, 68), (94, 64, 48))
_HAIR_RGB: tuple[RGB, ...] = ((62, 46, 36), (34, 28, 26), (120, 86, 52), (168, 134, 88), (132, 128, 124))
_SHOES_RGB: tuple[RGB, ...] = ((44, 42, 44), (228, 226, 222), (104, 72, 50), (70, 84, 110))
_BACKPACKS_RGB: tuple[RGB, ...] = ((206, 108, 40), (48, 60, 84), (60, 62, 60), (150, 40, 50))
_UNIFORMS_RGB: tuple[tuple[RGB, RGB], ...] = (
    ((206, 92, 36), (34, 58, 116)),
    ((30, 84, 168), (30, 84, 168)),
    ((36, 120, 70), (36, 120, 70)),
    ((176, 36, 40), (36, 52, 108)),
    ((214, 168, 44), (40, 104, 66)),
)
"""Tops and trousers of working clothes, in strong colours."""
_DYE = 6.0
"""Standard deviation between clothes of one colour, sRGB."""


def draw_looks(count: int, alike: int, uniformed: int, rng: np.random.Generator) -> list[PersonLook]:
    """Draw looks of people, the target's first.

    The next ``alike`` people wear a top of the target's colour, the first of them also trousers of its colour; no one
    else's top has that colour. With ``uniformed`` > 0 the target and the next ``uniformed`` people wear the same
    working clothes instead.
    """
    target = _look(_TOPS_RGB[rng.integers(len(_TOPS_RGB))], rng)
    if uniformed > 0:
        uniform = _UNIFORMS_RGB[rng.integers(len(_UNIFORMS_RGB))]
        target = _in_uniform(target, uniform)
    own = target.top_rgb
    others = [top for top in _TOPS_RGB if np.abs(np.subtract(top, own)).max() > 4 * _DYE]
    looks = [target]
    for k in range(1, count):
        look = _look(own if k <= alike else others[rng.integers(len(others))], rng)
        if k == 1 and alike > 0:
            look = replace(look, legwear_rgb=_dyed(target.legwear_rgb, rng), legwear=target.legwear)
        if k <= uniformed:
            look = _in_uniform(look, uniform)
        looks.append(look)
    return looks


def _look(top_rgb: RGB, rng: np.random.Generator) -> PersonLook:
    is_tall = rng.random() < 0.5
    return PersonLook(
        stature_m=float(np.clip(rng.normal(1.77 if is_tall else 1.65, 0.06), 1.52, 1.93)),
        build=float(rng.uniform(0.9, 1.15)),
        skin_rgb=_of(_SKIN_RGB, rng),
        hair_rgb=_of(_HAIR_RGB, rng),
        hair_style=rng.choice(["short", "long"], p=[0.6, 0.4]),
        cap_rgb=_of(_BACKPACKS_RGB, rng) if rng.random() < 0.1 else None,
        top_rgb=_dyed(top_rgb, rng),
        top_pattern=rng.choice(["plain", "stripes", "check"], p=[0.7, 0.15, 0.15]),
        sleeves=rng.choice(["long", "short"], p=[0.7, 0.3]),
        legwear=rng.choice(["trousers", "shorts"], p=[0.85, 0.15]),
        legwear_rgb=_dyed(_of(_LEGWEAR_RGB, rng), rng),
        shoes_rgb=_of(_SHOES_RGB, rng),
        backpack_rgb=_of(_BACKPACKS_RGB, rng) if rng.random() < 0.2 else None,
    )


def _in_uniform(look: PersonLook, uniform: tuple[RGB, RGB]) -> PersonLook:
    top_rgb, legwear_rgb = uniform
    return replace(
        look, top_rgb=top_rgb, top_pattern="plain", sleeves="long", legwear="trousers", legwear_rgb=legwear_rgb
    )


def _of(options: tuple[RGB, ...], rng: np.random.Generator) -> RGB:
    return options[rng.integers(len(options))]


def _dyed(rgb: RGB, rng: np.random.Generator) -> RGB:
    red, green, blue = np.clip(np.round(np.array(rgb) + rng.normal(0.0, _DYE, 3)), 0, 255).astype(int).tolist()
    return red, green, blue
