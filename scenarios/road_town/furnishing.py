"""What stands in a town beside houses, trees and car parks: hedges, shrubs, fences, bins, signs; and houses' looks.

All of it is drawn for a finished town, each kind from a generator of its own, so that a town without it stays the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.blocks import FreeGround
from scenarios.road_town.layout import Building, Layout, Prop
from scenarios.road_town.presets import RoadTown
from sim.meshes.varied_house import LEVEL, SLOPING, WINDOWS, Form, HouseStyle
from sim.rng import generator

SIGN_FROM_KERB_M = 0.42
"""People walk farther from the kerb."""
ZEBRA_FROM_NODE_M = 8.0
"""Distance of a crossing for people from the middle of a crossing of streets."""
_ENDS_M = 16
"""Signs stand at least so far from a street's ends."""
_SLOPING_FORMS: tuple[Form, ...] = ("gable", "gable", "cross", "wing", "wing", "hip")
_FRONT_M = np.arange(8.8, 1.6, -0.4)
"""Distances before a house at which its front hedge is tried, the farthest first."""
_PIECE_M = 4.2


def furnish(layout: Layout, preset: RoadTown, seed: int) -> Layout:
    """Return a town with what a configuration adds to it."""
    if preset.buildings == "varied":
        rng = generator(seed, "house styles")
        layout = replace(layout, buildings=tuple(_styled(building, rng) for building in layout.buildings))
    if preset.people[1] > 0 or preset.cyclists[1] > 0:
        layout = replace(layout, zebras=_zebras(layout, generator(seed, "zebras")))
    props: list[Prop] = []
    if preset.gardens == "grown":
        props += _grow_gardens(layout, generator(seed, "gardens"))
    if preset.signs[1] > 0:
        props += _put_signs(layout, preset.signs, generator(seed, "signs"))
    return replace(layout, props=tuple(props)) if props else layout


def _styled(building: Building, rng: np.random.Generator) -> Building:
    sloping = building.roof != "flat"
    form: Form = _SLOPING_FORMS[int(rng.integers(len(_SLOPING_FORMS)))] if sloping else "flat"
    if not sloping and rng.random() < 0.4:
        form = "stepped"
    weights = np.array((0.72, 0.18, 0.10) if sloping else (0.35, 0.2, 0.25, 0.2))
    roofings = SLOPING if sloping else LEVEL
    roofing = roofings[int(rng.choice(len(roofings), p=weights))]
    windows = WINDOWS[int(rng.integers(len(WINDOWS)))]
    return replace(building, style=HouseStyle(form, roofing, windows, int(rng.integers(2**31))))


def _zebras(layout: Layout, rng: np.random.Generator) -> tuple[tuple[int, float], ...]:
    """Draw the ends of streets at which people cross: most of those that have markings."""
    found = []
    for index, street in enumerate(layout.graph.streets):
        length_m = float(np.linalg.norm(np.diff(street.centre_m, axis=0), axis=1).sum())
        for arc_m in (ZEBRA_FROM_NODE_M, length_m - ZEBRA_FROM_NODE_M):
            if rng.random() < 0.75 and length_m > 4.0 * ZEBRA_FROM_NODE_M:
                found.append((index, arc_m))
    return tuple(found)


def _grow_gardens(layout: Layout, rng: np.random.Generator) -> list[Prop]:
    """Plant hedges or fences around houses, shrubs beside them, and put bins at some doors."""
    ground = FreeGround.of(layout)
    props: list[Prop] = []
    for building in layout.buildings:
        style = int(rng.integers(1 << 20))
        fenced = rng.random() < 0.28
        kind, width, height = ("fence", 0.14, 1.1) if fenced else ("hedge", 0.8, float(rng.uniform(1.0, 1.9)))
        for start, end in _borders(building, ground, rng):
            count = max(1, round(float(np.linalg.norm(end - start)) / _PIECE_M))
            steps, pieces = np.linspace(0.0, 1.0, count + 1), []
            for a, b in pairwise(steps):
                middle = start + 0.5 * (a + b) * (end - start)
                size = (float((b - a) * np.linalg.norm(end - start)), width, height)
                yaw = float(np.arctan2(*(end - start)[::-1]))
                if ground.is_free(middle, size[:2], yaw):
                    pieces.append(Prop(kind, _pair(middle), size, yaw, style))
            # Only now, since neighbouring pieces touch.
            for piece in pieces:
                ground.occupy(piece.rectangle)
            props += pieces
        for _ in range(int(rng.integers(1, 6))):
            place = _beside_house(building, rng.uniform(-0.5, 0.5, 2) * (14.0, 20.0) + np.array([0.0, 1.0]))
            side = float(rng.uniform(0.9, 2.2))
            if ground.take(place, (side, side), 0.0, 0.2):
                size = (side, side, side * float(rng.uniform(0.7, 1.3)))
                props.append(
                    Prop("shrub", _pair(place), size, float(rng.uniform(-3.1, 3.1)), int(rng.integers(1 << 20)))
                )
        if rng.random() < 0.5:
            along = float(rng.uniform(-0.4, 0.4)) * building.size_m[0]
            place = _beside_house(building, np.array([along, 0.5 * building.size_m[1] + 1.1]))
            size = (0.7 * float(rng.integers(1, 4)), 0.7, 1.05)
            if ground.take(place, size[:2], building.yaw_rad, 0.0):
                props.append(Prop("bin", _pair(place), size, building.yaw_rad, int(rng.integers(1 << 20))))
    return props


def _borders(
    building: Building, ground: FreeGround, rng: np.random.Generator
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield the ends of a garden's borders, some of which stay open: front beside the path and drives, sides, back."""
    half_x, half_y = 0.5 * building.size_m[0], 0.5 * building.size_m[1]
    side_m = half_x + float(rng.uniform(2.6, 4.2))
    back_m = half_y + float(rng.uniform(5.0, 10.0))
    front_m = half_y + 2.0
    for beyond_m in _FRONT_M:
        if ground.is_free(
            _beside_house(building, np.array([0.5 * half_x, half_y + beyond_m])), (1.5, 0.9), building.yaw_rad
        ):
            front_m = half_y + float(beyond_m)
            break
    lines = [
        ((-half_x, front_m), (-1.1, front_m)),
        ((1.1, front_m), (half_x, front_m)),
        ((-side_m, -back_m), (-side_m, front_m)),
        ((side_m, -back_m), (side_m, front_m)),
        ((-side_m + 0.6, -back_m), (side_m - 0.6, -back_m)),
    ]
    for (a, b), share in zip(lines, (0.7, 0.7, 0.6, 0.6, 0.6), strict=True):
        if rng.random() < share:
            yield _beside_house(building, np.array(a)), _beside_house(building, np.array(b))


def _beside_house(building: Building, local_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the place (2,) of a point in the house's own frame; its street lies to its left (+y)."""
    c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
    return np.array(building.centre_m) + np.array([c * local_m[0] - s * local_m[1], s * local_m[0] + c * local_m[1]])


def _put_signs(layout: Layout, numbers: tuple[int, int], rng: np.random.Generator) -> list[Prop]:
    """Put signs at kerbs; they face those who come on their side."""
    signs: list[Prop] = []
    right, wanted = layout.graph.right_sign, int(rng.integers(numbers[0], numbers[1] + 1))
    long = [street for street in layout.graph.streets if len(street.centre_m) > 2 * _ENDS_M + 6]
    for _ in range(wanted if long else 0):
        street = long[int(rng.integers(len(long)))]
        index = int(rng.integers(_ENDS_M, len(street.centre_m) - _ENDS_M))
        along = street.centre_m[index + 1] - street.centre_m[index - 1]
        along = along / np.linalg.norm(along) * rng.choice([-1.0, 1.0])
        aside = right * np.array([along[1], -along[0]])
        place = street.centre_m[index] + (0.5 * street.width_m + SIGN_FROM_KERB_M) * aside
        taken_m = [each.centre_m for each in signs] + [each.centre_m for each in layout.lamps]
        if any(np.hypot(*(place - other_m)) < 6.0 for other_m in taken_m):
            continue
        size = (0.1, 0.7, float(rng.uniform(2.3, 3.0)))
        signs.append(
            Prop("sign", _pair(place), size, float(np.arctan2(along[1], along[0])), int(rng.integers(1 << 20)))
        )
    return signs


def _pair(place_m: NDArray[np.float64]) -> tuple[float, float]:
    return float(place_m[0]), float(place_m[1])
