"""The plan of an episode, drawn before its first picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.building import Building, draw_building
from scenarios.stereo_follow.carried import Load, draw_carried, loads_of, without_backpack
from scenarios.stereo_follow.crowd import Crowd, draw_crowd
from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.furniture import furnished
from scenarios.stereo_follow.lighting import LightPlan, draw_light_plan
from scenarios.stereo_follow.plaza import draw_plaza, outdoors
from scenarios.stereo_follow.presets import StereoFollow
from sim.meshes.person import RGB, PersonLook
from sim.meshes.population import draw_person
from sim.motion.gait import phase_rate_radps
from sim.rng import generator

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


def of_many_builds(looks: list[PersonLook], alike: int, uniformed: int, rng: np.random.Generator) -> list[PersonLook]:
    """Return other people in the colours of ``looks``, see ``draw_looks``; who is dressed alike remains so."""
    made: list[PersonLook] = []
    for k, look in enumerate(looks):
        other = replace(draw_person(rng), top_rgb=look.top_rgb, legwear_rgb=look.legwear_rgb)
        if k == 1 and alike > 0:
            # The target's twin in clothes, whatever the build.
            worn = ("legwear", "sleeves", "top_pattern", "top_length", "inner_rgb")
            other = replace(other, **{name: getattr(made[0], name) for name in worn})
        if uniformed > 0 and k <= uniformed:
            other = replace(_in_uniform(other, (look.top_rgb, look.legwear_rgb)), top_length="hip", inner_rgb=None)
        made.append(other)
    return made


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


TARGET = 0
"""Index of the target among the people."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The plan of one episode.

    Attributes:
        preset, seed: of the episode. closed_loop: whether commands drive the robot.
        building, crowd, light: the static objects, the paths, the changes of the light.
        looks: of N people. loads: what each of them carries. phase_rad: (F, N) of their strides.
        places: (F,) of the target.
        dropped: (F,) whether the right picture is lost.
    """

    preset: StereoFollow
    seed: int
    closed_loop: bool
    building: Building
    crowd: Crowd
    light: LightPlan
    looks: tuple[PersonLook, ...]
    loads: tuple[list[Load], ...]
    phase_rad: NDArray[np.float64]
    places: tuple[str, ...]
    dropped: NDArray[np.bool_]


def make_plan(preset: StereoFollow, seed: int, *, closed_loop: bool, kept: Building | None = None) -> Plan:
    """Draw the plan of an episode.

    Args:
        seed: of the episode, see ``sim.rng.episode_seed``.
        kept: a building that other episodes share; None: the seed's own.
    """
    building = building_of(seed, preset.place, preset.rooms) if kept is None else kept
    floor_plan = building.plan
    crowd = draw_crowd(preset, floor_plan, generator(seed, "crowd"))
    places = tuple(floor_plan.place_of(place_m) for place_m in crowd.walks[TARGET].place_m)
    looks = draw_looks(len(crowd.walks), preset.alike, preset.uniformed, generator(seed, "wardrobe"))
    if preset.people_builds == "many":
        looks = of_many_builds(looks, preset.alike, preset.uniformed, generator(seed, "builds"))
    carried = draw_carried(preset, len(looks), generator(seed, "carried"))
    looks = [without_backpack(look, each) for look, each in zip(looks, carried, strict=True)]
    dropped = generator(seed, "lost pictures").random(preset.frame_count) < preset.dropped_share
    return Plan(
        preset,
        seed,
        closed_loop,
        building,
        crowd,
        draw_light_plan(preset, places, generator(seed, "light")),
        tuple(looks),
        tuple(loads_of(look, each) for look, each in zip(looks, carried, strict=True)),
        _phases(crowd, looks, preset.rate_hz, generator(seed, "strides")),
        places,
        dropped,
    )


@lru_cache(maxsize=1)
def building_of(seed: int, place: str, rooms: str) -> Building:
    """Return the building of an episode. The latest one is kept, and its light: episodes often come again at once.

    Args:
        place, rooms: see ``StereoFollow``.
    """
    plan = draw_floor_plan(generator(seed, "floor plan"))
    if place == "outdoors":
        rng = generator(seed, "plaza")
        return draw_plaza(outdoors(plan, rng), rng)
    building = draw_building(plan, generator(seed, "building"))
    return furnished(building, generator(seed, "furniture")) if rooms == "furnished" else building


def _phases(crowd: Crowd, looks: list[PersonLook], rate_hz: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the phase of each person's stride on each frame (F, N)."""
    rates = [
        [phase_rate_radps(look.stature_m, speed) for speed in walk.speed_mps]
        for walk, look in zip(crowd.walks, looks, strict=True)
    ]
    steps = np.array(rates).T / rate_hz
    first = rng.uniform(0.0, 2 * np.pi, steps.shape[1])
    return first + np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps[:-1], axis=0)])
