"""Moored boats and their ropes: they rise with the tide, swing as far as ropes are slack, and roll with the swell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.conditions import LOWEST_M, Tide, float_poses, rocking, sway
from scenarios.harbour.layout import FIXED, Site
from scenarios.harbour.seakeeping import afloat_on
from sim.mesh import TexturedMesh
from sim.meshes.boat import boat
from sim.meshes.facets import Facets, swatch_uv
from sim.meshes.thermal_paint import parts_palette
from sim.thermal.waves import SeaWaves

SEGMENTS = 6
"""Of a rope."""
_ROPE_M = 0.06
_BOLLARD_TOP_M = 0.5
_FENDER_M = 0.45


@dataclass(frozen=True, slots=True)
class Moored:
    """One moored boat.

    Attributes:
        model, length_m, beam_m: see ``sim.meshes.boat.boat``.
        anchor_m: (2,) middle of the berth, or the buoy. heading_rad: at the berth, or at the buoy off the wind's eye.
        swings: about a buoy.
        seed: of its motion.
        off: (2,) unit vector from the wall to the water.
        posts_m: bollards, to the nearest of which its ropes are tied.
    """

    model: str
    length_m: float
    beam_m: float
    anchor_m: tuple[float, float]
    heading_rad: float
    swings: bool
    seed: int
    off: tuple[float, float] = (-1.0, 0.0)
    posts_m: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Ride:
    """A moored boat at F times: its poses (F, 4, 4) and those of its ropes' segments (F, ropes * SEGMENTS, 4, 4)."""

    T_world_boat: NDArray[np.float64]
    T_world_rope: NDArray[np.float64]


def draw_moored(buoys: int, rng: np.random.Generator, site: Site = FIXED) -> list[Moored]:
    """Draw a boat for each berth that is not free, and for the first ``buoys`` buoys."""
    boats = []
    for berth in site.berths:
        if not berth.is_free:
            model = str(rng.choice(["fisher", "yacht", "launch"], p=[0.55, 0.2, 0.25]))
            length = rng.uniform(5.5, 6.5) if model == "launch" else rng.uniform(7.5, 9.5)
            beam, (x, y) = length * rng.uniform(0.31, 0.37), berth.off
            wall_x = site.wall_x_m if berth.wall_x_m is None else berth.wall_x_m
            place = (wall_x + x * _FENDER_M + 0.5 * x * beam, berth.y_m + y * (_FENDER_M + 0.5 * beam))
            seed = int(rng.integers(2**31))
            boats.append(Moored(model, length, beam, place, berth.heading_rad, False, seed, berth.off, site.bollards_m))
    for place in site.buoys_m[:buoys]:
        length, heading = rng.uniform(4.6, 5.6), rng.normal(0.0, 0.2)
        model = str(rng.choice(["launch", "yacht"]))
        boats.append(Moored(model, length, 0.36 * length, place, heading, True, int(rng.integers(2**31))))
    return boats


def mesh_of(moored: Moored) -> TexturedMesh:
    """Return the boat's mesh."""
    return boat(moored.model, moored.length_m, moored.beam_m)


def rope_lengths_m(moored: Moored) -> NDArray[np.float64]:
    """Return the lengths (ropes,): at the lowest tide they are nearly taut."""
    if moored.swings:
        return np.array([3.2])
    start, end = _rope_ends(moored, _at_berth(moored, np.array([LOWEST_M]))[0])
    return np.linalg.norm(end - start, axis=1) + 0.25


def rope_mesh(length_m: float) -> TexturedMesh:
    """Return one of a rope's segments, along x from 0."""
    facets = Facets()
    reach = 1.03 * length_m / SEGMENTS
    facets.box((0.0, -0.5 * _ROPE_M, -0.5 * _ROPE_M), (reach, 0.5 * _ROPE_M, 0.5 * _ROPE_M), swatch_uv(0, 1))
    return facets.mesh(parts_palette(1))


def buoy_mesh() -> TexturedMesh:
    """Return a buoy on its waterline."""
    facets = Facets()
    facets.box((-0.35, -0.35, -0.3), (0.35, 0.35, 0.35), swatch_uv(0, 1))
    return facets.mesh(parts_palette(1))


def ride(
    moored: Moored,
    time_s: NDArray[np.float64],
    tide: Tide,
    wave_height_m: NDArray[np.float64],
    wind_mps: NDArray[np.float64],
    wind_rad: NDArray[np.float64],
    waves: Sequence[SeaWaves] = (),
    days: Sequence[int] = (),
) -> Ride:
    """Return the boat and its ropes at times (F,), in waves (F,) and wind (F,).

    Args:
        wind_rad: where it blows to: all that swing lie there of their buoys, bow to the wind.
        waves: of each day, on which it floats on ``days`` (F,); none: it moves by chance.
    """
    rng = np.random.default_rng(moored.seed)
    level_m = tide.level_m(time_s)
    rocked = rocking(time_s, wave_height_m, moored.length_m, rng)
    push = 0.3 + wind_mps / 8.0
    if moored.swings:
        heading = (
            wind_rad
            + np.pi
            + moored.heading_rad
            + push * (0.35 * sway(time_s, (90.0, 400.0), rng) + 0.25 * sway(time_s, (1500.0, 9000.0), rng))
        )
        reach = 2.2 + 0.5 * moored.length_m
        place = np.column_stack(
            [moored.anchor_m[0] - reach * np.cos(heading), moored.anchor_m[1] - reach * np.sin(heading), level_m]
        )
    else:
        # The higher the water, the more rope hangs slack: the boat may move further.
        slack = 0.12 + 0.22 * (level_m - LOWEST_M)
        off = slack * np.minimum(push, 1.5) * (1.0 + 0.6 * sway(time_s, (25.0, 120.0), rng))
        along = 0.8 * slack * np.minimum(push, 1.5) * sway(time_s, (30.0, 150.0), rng)
        place = _at_berth(moored, level_m)[:, :3, 3]
        (x, y), off = moored.off, np.maximum(off, 0.0)
        place[:, 0] += x * off + y * along
        place[:, 1] += y * off - x * along
        heading = moored.heading_rad + 0.12 * slack * sway(time_s, (30.0, 120.0), rng)
    for day in set(days) if waves else ():
        then = np.array(days) == day
        size, at = (moored.length_m, moored.beam_m), (time_s[then], place[then, :2], heading[then])
        for name, moved in asdict(afloat_on(waves[day], *at, *size)).items():
            getattr(rocked, name)[then] = moved
    place[:, 2] += rocked.heave_m
    T_boat = float_poses(place, heading, rocked.roll_rad, rocked.pitch_rad)
    lengths = rope_lengths_m(moored)
    start, end = _rope_ends(moored, T_boat, level_m)
    return Ride(T_boat, np.concatenate([_hang(start[:, k], end[:, k], each) for k, each in enumerate(lengths)], axis=1))


def _at_berth(moored: Moored, level_m: NDArray[np.float64]) -> NDArray[np.float64]:
    place = np.column_stack([np.broadcast_to(moored.anchor_m, (len(level_m), 2)), level_m])
    zero = np.zeros(len(level_m))
    return float_poses(place, zero + moored.heading_rad, zero, zero)


def _rope_ends(
    moored: Moored, T_boat: NDArray[np.float64], level_m: NDArray[np.float64] | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return both ends (..., ropes, 3) of the ropes of a boat at poses (..., 4, 4): on deck, and ashore."""
    half, deck = 0.5 * moored.length_m, 0.11 * moored.length_m
    if moored.swings:
        cleats = np.array([(0.94 * half, 0.0, 1.2 * deck)])
    else:
        h, (x, y) = moored.heading_rad, moored.off
        # Its left is where the wall is, or its right.
        side = np.sign(x * np.sin(h) - y * np.cos(h)) * 0.4 * moored.beam_m
        along = ((0.85, 1.2), (-0.9, 1.0), (0.3, 1.0), (-0.3, 1.0))
        cleats = np.array([(share * half, side, rise * deck) for share, rise in along])
    start = np.einsum("...ij,rj->...ri", T_boat[..., :3, :3], cleats) + T_boat[..., None, :3, 3]
    end = np.empty_like(start)
    if moored.swings:
        end[..., 0, :2] = moored.anchor_m
        end[..., 0, 2] = 0.0 if level_m is None else level_m + 0.3
    else:
        posts_m, anchor_m = np.array(moored.posts_m), np.array(moored.anchor_m)
        ahead = np.array([np.cos(moored.heading_rad), np.sin(moored.heading_rad)])
        for k, reach in enumerate((half + 2.5, -half - 2.5, -0.35 * half, 0.35 * half)):
            away = np.hypot(*(posts_m - (anchor_m + reach * ahead)).T)
            end[..., k, :] = *posts_m[int(away.argmin())], _BOLLARD_TOP_M
    return start, end


def _hang(start_m: NDArray[np.float64], end_m: NDArray[np.float64], length_m: float) -> NDArray[np.float64]:
    """Return the poses (F, SEGMENTS, 4, 4) of a rope between two ends (F, 3): a parabola with the rope's length.

    Its sag is ``sqrt(3/8 chord (length - chord))``, the first term of its arc length; 0 if the rope is taut.
    """
    chord = np.linalg.norm(end_m - start_m, axis=1)
    sag = np.sqrt(0.375 * chord * np.maximum(length_m - chord, 0.0))
    share = np.linspace(0.0, 1.0, SEGMENTS + 1)[None, :, None]
    points = start_m[:, None] + share * (end_m - start_m)[:, None]
    points[..., 2] -= 4.0 * sag[:, None] * (share * (1.0 - share))[..., 0]
    ahead = np.diff(points, axis=1)
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    level = np.hypot(ahead[..., 0], ahead[..., 1])
    heading, pitch = np.arctan2(ahead[..., 1], ahead[..., 0]), -np.arctan2(ahead[..., 2], level)
    return float_poses(points[:, :-1], heading, np.zeros_like(pitch), pitch)
