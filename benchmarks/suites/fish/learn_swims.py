"""Learns the regressions that ``trackers.swimmer`` ships, from simulated swims of many kinds of fish."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.character import AYU, ZEBRAFISH, Character
from scenarios.fish_tank.shoal import Swims, swim
from sim.motion.swim import swim_pose
from sim.rng import generator
from trackers.atomic_file import write_atomic
from trackers.gaps.types import Piece
from trackers.swimmer.extrapolation import KNOTS, samples_ahead
from trackers.swimmer.interpolation import GAPS, SHARES, samples_between
from trackers.swimmer.method import PRIOR_FILE
from trackers.swimmer.regression import Regression, Samples, first_fit
from trackers.swimmer.windows import Recording

PRIOR_PATH = Path(__file__).resolve().parents[3] / "trackers" / "swimmer" / PRIOR_FILE
RATE_HZ = 30.0
_FRAMES = 1200
_WATER_M = (0.6, 0.42, 0.12)
_PX_PER_M = 1000.0
_NOISE_PX = (0.1, 1.0)
_LINE_NOISE_PX = 0.5
_LENGTH_M = (0.025, 0.045)
_MOST_FISH = 8


def recording_of(seed: int) -> Recording:
    """Return the measured tracks of a shoal of random character; every second seed has smooth swimmers."""
    rng = generator(seed, "learn-swims")
    smooth = seed % 2 == 1
    character = _character(AYU if smooth else ZEBRAFISH, rng)
    count = 1 if smooth else int(rng.integers(1, _MOST_FISH + 1))
    length_m = rng.uniform(*_LENGTH_M, count)
    swims = swim(_WATER_M, length_m, _FRAMES, RATE_HZ, character, rng)
    noise_px = float(np.exp(rng.uniform(*np.log(_NOISE_PX))))
    x = swims.position_m[..., :2] * _PX_PER_M + noise_px * rng.normal(size=(_FRAMES, count, 2))
    # The picture's y axis points down.
    x[..., 1] *= -1.0
    return Recording([Piece(0, x[:, n], 1.0 / RATE_HZ, *_posture(swims, length_m, n, rng)) for n in range(count)])


def _posture(
    swims: Swims, length_m: NDArray[np.float64], n: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return measured headings (T,) and centre lines (T, K, 2) of one fish, as seen from above."""
    frames = len(swims.yaw_rad)
    pose = swim_pose(
        np.full(frames, length_m[n]),
        swims.position_m[:, n],
        swims.yaw_rad[:, n],
        swims.pitch_rad[:, n],
        swims.joints_rad[:, n],
    )
    line = pose.centre_line_m[..., :2] * [_PX_PER_M, -_PX_PER_M]
    line = line + _LINE_NOISE_PX * rng.normal(size=line.shape)
    front = line[:, 0] - line[:, line.shape[1] // 2]
    return np.arctan2(front[:, 1], front[:, 0]), line


def _character(like: Character, rng: np.random.Generator) -> Character:
    """Return a fish that differs from ``like`` by up to a factor of two in every respect."""
    return Character(*(value * float(np.exp(rng.uniform(-np.log(2), np.log(2)))) for value in like))


def learn_swims(seeds: Sequence[int]) -> dict[str, Any]:
    """Return the content of the file that ``trackers.swimmer`` reads."""
    recordings = [recording_of(seed) for seed in seeds]
    ahead = [{"ahead": knot} | _fit(recordings, lambda each, knot=knot: samples_ahead(each, knot)) for knot in KNOTS]
    between = [
        {"gap": gap, "share": share}
        | _fit(recordings, lambda each, gap=gap, share=share: samples_between(each, gap, share))
        for gap in GAPS
        for share in SHARES
    ]
    return {"ahead": ahead, "between": between}


def write_prior(content: dict[str, Any], command: str) -> Path:
    """Write the regressions to the file that is shipped; return its path."""
    write_atomic(PRIOR_PATH, json.dumps(content | {"command": command}, indent=1) + "\n")
    return PRIOR_PATH


def _fit(recordings: Sequence[Recording], sampled: Callable[[Recording], Samples]) -> dict[str, list[float]]:
    regression = first_fit(_joined([sampled(each) for each in recordings]))
    return {name: [float(f"{value:.5g}") for value in getattr(regression, name)] for name in _names()}


def _names() -> Iterator[str]:
    return (field.name for field in dataclasses.fields(Regression))


def _joined(parts: Sequence[Samples]) -> Samples:
    """Return all samples; each recording has the same weight."""
    arrays = [
        np.concatenate([getattr(part, name) for part in parts]) for name in ("features", "step", "scales", "fold")
    ]
    weight = np.concatenate([np.full(len(part.step), 100.0 / max(len(part.step), 1)) for part in parts])
    return Samples(*arrays[:3], weight, arrays[3], sum(part.independent for part in parts), parts[0].added)
