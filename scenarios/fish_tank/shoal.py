"""A shoal in a tank: burst-and-coast swimming between walls, with depth layers, mates and bodies that bend.

Fish gain speed and turn in short bursts with tail beats and glide between them; speed then decays exponentially.
Walls turn them, mates attract them weakly. Each keeps to a depth that it changes now and then; who meets another fish
at the same depth gives way up or down, so that bodies never penetrate each other, the walls, the floor or the surface.
The equations are those of ``shoal_kernels``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.presets import Character
from scenarios.fish_tank.shoal_kernels import School, run
from sim.checks import check
from sim.meshes.fish import SPECIES, Species
from sim.motion.swim import JOINT_COUNT
from sim.render.compilation import announce_compilation

LONGEST_STEP_S = 1.0 / 120.0
"""Frames farther apart than this are reached in several equal steps."""
_SETTLING_S = 8.0
"""Time that the shoal swims before frame 0, so that the initial places no longer matter."""
_MAY_BE_ENDLESS = ("burst_interval_s", "depth_s")


class Kind(NamedTuple):
    """What of a fish depends on its species.

    Attributes:
        number: of the species; fish see mates in their own.
        height: factor of the body's height, see ``FishLook``.
        pace: factor of speeds and of distances at which walls and mates count.
        bond: factor of ``Character.school``.
    """

    number: int
    height: float
    pace: float
    bond: float


_BONDS: dict[Species, float] = {"zebrafish": 1.0, "tetra": 1.6, "guppy": 0.5, "barb": 1.2}
"""Tetras keep together, guppies hardly do: our choice."""
_SPEED_EXPONENT = 0.6
"""Of the growth of speed with length: within fish of one shape speeds in lengths a second fall with length (Bainbridge,
Journal of Experimental Biology, 1958; Videler and Wardle, Reviews in Fish Biology and Fisheries, 1991).
"""


def kind_of(species: Species) -> Kind:
    """Return what a species changes in how fish swim, relative to zebrafish, whose ``Character`` is fitted."""
    look, usual = SPECIES[species], SPECIES["zebrafish"]
    pace = (look.length_m / usual.length_m) ** _SPEED_EXPONENT
    return Kind(list(SPECIES).index(species), look.height, pace, _BONDS[species])


@dataclass(frozen=True, eq=False)
class Swims:
    """Motion of N fish over T frames, all float64.

    Attributes:
        position_m: (T, N, 3) of the middle of the body; origin at the middle of the tank's floor, z up.
        yaw_rad, pitch_rad: (T, N) of the middle of the body; yaw is continuous over time.
        joints_rad: (T, N, S - 1), see ``sim.motion.swim.swim_pose``.
        speed_mps: (T, N), along the body.
    """

    position_m: NDArray[np.float64]
    yaw_rad: NDArray[np.float64]
    pitch_rad: NDArray[np.float64]
    joints_rad: NDArray[np.float64]
    speed_mps: NDArray[np.float64]


def swim(
    volume_m: tuple[float, float, float],
    length_m: NDArray[np.float64],
    frame_count: int,
    rate_hz: float,
    character: Character,
    rng: np.random.Generator,
    kinds: Sequence[Kind] = (),
    *,
    is_round: bool = False,
) -> Swims:
    """Return the motion of a shoal.

    Args:
        volume_m: extent of the water in x, y and z.
        length_m: (N,) of the fish.
        kinds: of each fish; none: all are of one species.
        is_round: whether the tank is round, as wide as the water's extent in x.
        frame_count, rate_hz: of the frames, > 0.

    Raises:
        ValueError: if the water is too small for the fish, or a number is impossible.
    """
    size_m, length_m = np.asarray(volume_m, dtype=float), np.asarray(length_m, dtype=float)
    count = len(length_m)
    _check_character(character)
    check("length_m", count > 0, "the length of at least one fish", length_m)
    check("kinds", len(kinds) in (0, count), f"one for each of {count} fish, or none", len(kinds))
    check("frame_count", frame_count > 0, "a number > 0", frame_count)
    check("rate_hz", rate_hz > 0, "a rate > 0 Hz", rate_hz)
    longest_m = float(length_m.max())
    room = size_m[0] > 4 * longest_m and size_m[1] > 4 * longest_m and size_m[2] > longest_m
    check("volume_m", room, f"at least 4 x 4 x 1 lengths of the longest fish, {longest_m} m", volume_m)
    crowding = float((length_m**3).sum()) / float(size_m.prod())
    check("length_m", crowding < 0.25, "fish whose lengths cubed add up to less than a quarter of the water", crowding)
    school = _put_in(size_m, length_m, character, rng)
    if kinds:
        school = school._replace(
            height_m=length_m * [kind.height for kind in kinds],
            pace=np.array([kind.pace for kind in kinds]),
            bond=np.array([kind.bond for kind in kinds]),
            kind=np.array([kind.number for kind in kinds]),
        )
    steps = math.ceil(1.0 / (rate_hz * LONGEST_STEP_S) - 1e-9)
    interval_s = 1.0 / (rate_hz * steps)
    announce_compilation(run)
    settling = math.ceil(_SETTLING_S * rate_hz)
    run(school, character, size_m, is_round, steps * settling, interval_s, rng)
    swims = Swims(
        np.empty((frame_count, count, 3)),
        np.empty((frame_count, count)),
        np.empty((frame_count, count)),
        np.empty((frame_count, count, JOINT_COUNT)),
        np.empty((frame_count, count)),
    )
    for frame in range(frame_count):
        if frame > 0:
            run(school, character, size_m, is_round, steps, interval_s, rng)
        swims.position_m[frame] = school.position_m
        swims.yaw_rad[frame], swims.pitch_rad[frame] = school.yaw_rad, school.pitch_rad
        swims.joints_rad[frame], swims.speed_mps[frame] = school.joints_rad, school.speed_mps
    return swims


def _check_character(character: Character) -> None:
    for name, value in character._asdict().items():
        is_time = name.endswith("_s")
        good = (value > 0 if is_time else value >= 0) and (np.isfinite(value) or name in _MAY_BE_ENDLESS)
        expected = "a time > 0 s" if is_time else "a finite number >= 0"
        check(f"character.{name}", good, expected, value)


def _put_in(
    size_m: NDArray[np.float64], length_m: NDArray[np.float64], character: Character, rng: np.random.Generator
) -> School:
    """Return fish at rest anywhere in the water; the first step moves them apart."""
    count = len(length_m)
    low_m, high_m = -0.5 * size_m, 0.5 * size_m
    low_m[2], high_m[2] = 0.0, size_m[2]
    inset_m = np.array([0.6, 0.6, 0.15]) * float(length_m.max())
    wait_s = rng.uniform(0.0, 1.0, count) * character.burst_interval_s
    return School(
        length_m=length_m,
        position_m=rng.uniform(low_m + inset_m, high_m - inset_m, (count, 3)),
        velocity_mps=np.zeros((count, 3)),
        yaw_rad=rng.uniform(-np.pi, np.pi, count),
        pitch_rad=np.zeros(count),
        joints_rad=np.zeros((count, JOINT_COUNT)),
        speed_mps=np.full(count, character.cruise_mps),
        mood=character.mood_spread * np.repeat(rng.normal(size=(count, 1)), 2, axis=1),
        veer_radps=character.veer_radps * np.repeat(rng.normal(size=(count, 1)), 2, axis=1),
        wait_s=wait_s,
        burst_left_s=np.zeros(count),
        push_mps2=np.zeros(count),
        turn_at_s=np.full(count, np.inf),
        turn_rad=np.zeros(count),
        wanted_z_m=rng.uniform(low_m[2] + inset_m[2], high_m[2] - inset_m[2], count),
        depth_wait_s=rng.exponential(character.depth_s, count),
        beat=np.column_stack([rng.uniform(0.0, 2.0 * np.pi, count), np.zeros(count)]),
        bend_rad=np.zeros((count, JOINT_COUNT)),
        height_m=length_m,
        pace=np.ones(count),
        bond=np.ones(count),
        kind=np.zeros(count, np.int64),
    )
