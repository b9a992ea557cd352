"""The plan of an episode, drawn before its first picture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.building import Building, draw_building
from scenarios.stereo_follow.crowd import Crowd, draw_crowd
from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.light_plan import LightPlan, draw_light_plan
from scenarios.stereo_follow.presets import StereoFollow
from scenarios.stereo_follow.wardrobe import draw_looks
from sim.meshes.person import PersonLook
from sim.motion.gait import phase_rate_radps
from sim.rng import generator

TARGET = 0
"""Index of the target among the people."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The plan of one episode.

    Attributes:
        preset, seed: of the episode. closed_loop: whether commands drive the robot.
        building, crowd, light: the static objects, the paths, the changes of the light.
        looks: of N people. phase_rad: (F, N) of their strides.
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
    phase_rad: NDArray[np.float64]
    places: tuple[str, ...]
    dropped: NDArray[np.bool_]


def make_plan(preset: StereoFollow, seed: int, *, closed_loop: bool, kept: Building | None = None) -> Plan:
    """Draw the plan of an episode.

    Args:
        seed: of the episode, see ``sim.rng.episode_seed``.
        kept: a building that other episodes share; None: the seed's own.
    """
    building = building_of(seed) if kept is None else kept
    floor_plan = building.plan
    crowd = draw_crowd(preset, floor_plan, generator(seed, "crowd"))
    places = tuple(floor_plan.place_of(place_m) for place_m in crowd.walks[TARGET].place_m)
    looks = draw_looks(len(crowd.walks), preset.alike, preset.uniformed, generator(seed, "wardrobe"))
    dropped = generator(seed, "lost pictures").random(preset.frame_count) < preset.dropped_share
    return Plan(
        preset,
        seed,
        closed_loop,
        building,
        crowd,
        draw_light_plan(preset, places, generator(seed, "light")),
        tuple(looks),
        _phases(crowd, looks, preset.rate_hz, generator(seed, "strides")),
        places,
        dropped,
    )


@lru_cache(maxsize=1)
def building_of(seed: int) -> Building:
    """Return the building of an episode. The latest one is kept, and its light: episodes often come again at once."""
    return draw_building(draw_floor_plan(generator(seed, "floor plan")), generator(seed, "building"))


def _phases(crowd: Crowd, looks: list[PersonLook], rate_hz: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the phase of each person's stride on each frame (F, N)."""
    rates = [
        [phase_rate_radps(look.stature_m, speed) for speed in walk.speed_mps]
        for walk, look in zip(crowd.walks, looks, strict=True)
    ]
    steps = np.array(rates).T / rate_hz
    first = rng.uniform(0.0, 2 * np.pi, steps.shape[1])
    return first + np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps[:-1], axis=0)])
