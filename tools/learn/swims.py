"""``python -m tools learn-swims``: learn from simulated swims what gap methods ship.

``trackers.swimmer`` ships regressions, learnt from many kinds of fish; ``ca_kalman`` its noise, by maximum likelihood
on the track of the common detector in episodes of preset ``paper-c``; damped velocity its decay, from ``standard``.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.cli.arguments import DevelopmentSeeds, seeds_text
from benchmarks.judges.fish.measured import Measurement
from scenarios import catalog
from scenarios.fish_tank.presets import AYU, PRESETS, ZEBRAFISH, Character
from scenarios.fish_tank.shoal import swim
from scenarios.fish_tank.truth import FishTruth
from sim.motion.swim import swim_pose
from sim.rng import generator
from trackers.atomic_file import write_atomic
from trackers.baselines.gap_methods import DECAY_FILE, DampedParameters, DampedVelocity
from trackers.gap_kalman.ca_kalman import NOISE_FILE, CaKalmanParameters, log_likelihood
from trackers.gaps import Piece
from trackers.swimmer.features import Recording
from trackers.swimmer.method import GAPS, KNOTS, PRIOR_FILE, SHARES, samples_ahead, samples_between
from trackers.swimmer.regression import Samples, first_fit

TRACKERS = Path(__file__).resolve().parents[2] / "trackers"
PRIOR_PATH = TRACKERS / "swimmer" / PRIOR_FILE
NOISE_PATH = TRACKERS / "gap_kalman" / NOISE_FILE
DECAY_PATH = TRACKERS / "baselines" / DECAY_FILE
Array = NDArray[np.float64]
RATE_HZ = 30.0
_FRAMES = 1200
_WATER_M = (0.6, 0.42, 0.12)
_PX_PER_M = 1000.0
_NOISE_PX = (0.1, 1.0)
_PRESET_NOISE_PX = 0.3
_FITTED_FISH = 8
_LINE_NOISE_PX = 0.5
_LENGTH_M = (0.025, 0.045)
_MOST_FISH = 8
_EPISODES, _PRESET_SEEDS = 6, 12


@dataclass(frozen=True)
class LearnSwims:
    """Learn how fish go on from simulated swims, and write it to the files that gap methods load.

    Our regressions learn from many kinds of fish, the noise of ca_kalman from at most 6 episodes of preset paper-c, and
    the decay of damped velocity from at most 12 swims of standard.

    Attributes:
        seeds: swims A to B - 1, or A alone, below 10,000.
    """

    seeds: DevelopmentSeeds = range(80)
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        command = f"python -m tools learn-swims --seeds {seeds_text(self.seeds)}"
        slow = [detected_track("paper-c", seed) for seed in self.seeds[:_EPISODES]]
        usual = [piece for seed in self.seeds[:_PRESET_SEEDS] for piece in preset_tracks("standard", seed)]
        print(write(NOISE_PATH, asdict(fit_noise(slow)), command))
        print(write(DECAY_PATH, {"decay_frames": fit_decay(usual)}, command))
        print(write(PRIOR_PATH, learn_swims(self.seeds), command))
        return 0


def recording_of(seed: int) -> Recording:
    """Return the measured tracks of a shoal of random character; every second seed has smooth swimmers."""
    rng = generator(seed, "learn-swims")
    smooth = seed % 2 == 1
    character = _character(AYU if smooth else ZEBRAFISH, rng)
    if smooth:
        # As slow as the one and as swift as the other.
        logs = np.log([AYU.cruise_mps, ZEBRAFISH.burst_mps])
        character = character._replace(cruise_mps=float(np.exp(rng.uniform(*logs))))
    count = 1 if smooth else int(rng.integers(1, _MOST_FISH + 1))
    noise_px = float(np.exp(rng.uniform(*np.log(_NOISE_PX))))
    return Recording(_swum(character, rng.uniform(*_LENGTH_M, count), noise_px, rng))


def _swum(character: Character, length_m: Array, noise_px: float, rng: np.random.Generator) -> list[Piece]:
    """Return tracks as seen from above, with white noise on positions and centre lines."""
    swims = swim(_WATER_M, length_m, _FRAMES, RATE_HZ, character, rng)
    # The picture's y axis points down.
    x = swims.position_m[..., :2] * [_PX_PER_M, -_PX_PER_M]
    x = x + noise_px * rng.normal(size=x.shape)
    pieces = []
    for n, length in enumerate(length_m):
        joints = (each[:, n] for each in (swims.position_m, swims.yaw_rad, swims.pitch_rad, swims.joints_rad))
        pose = swim_pose(np.full(len(swims.yaw_rad), length), *joints)
        line = pose.centre_line_m[..., :2] * [_PX_PER_M, -_PX_PER_M]
        line = line + _LINE_NOISE_PX * rng.normal(size=line.shape)
        front = line[:, 0] - line[:, line.shape[1] // 2]
        pieces.append(Piece(0, x[:, n], 1.0 / RATE_HZ, np.arctan2(front[:, 1], front[:, 0]), line))
    return pieces


def detected_track(preset: str, seed: int, frame_count: int | None = None) -> Piece:
    """Return the track of the only fish of an episode, or of its first frames, as the common detector measures it."""
    episode = catalog.scenario("fish-tank").episode(preset, seed)
    measurement = Measurement(episode.start.background, 1.0 / episode.rate_hz)
    for _ in range(frame_count or episode.frame_count):
        frame = episode.step()
        assert isinstance(frame.truth, FishTruth)
        measurement.see(frame.observation, frame.truth, np.ones(1, dtype=bool))
    episode.close()
    tracks = measurement.tracks()
    return tracks.piece(0, 0, len(tracks.position_px))


def preset_tracks(preset: str, seed: int) -> list[Piece]:
    """Return tracks of a preset's fish, with white noise in place of a detector."""
    rng, fish = generator(seed, f"learn-swims/{preset}"), PRESETS[preset]
    length_m = rng.uniform(*_LENGTH_M, min(fish.fish, _FITTED_FISH))
    return _swum(fish.character, length_m, _PRESET_NOISE_PX, rng)


def _character(like: Character, rng: np.random.Generator) -> Character:
    """Return a fish that differs from ``like`` by up to a factor of two in every respect."""
    return Character(*(value * float(np.exp(rng.uniform(-np.log(2), np.log(2)))) for value in like))


def learn_swims(seeds: Sequence[int]) -> dict[str, Any]:
    """Return the content of the file that ``trackers.swimmer`` reads."""
    recordings = [recording_of(seed) for seed in seeds]
    ahead = [{"ahead": knot} | _fit([samples_ahead(each, knot) for each in recordings]) for knot in KNOTS]
    between = [
        {"gap": gap, "share": share} | _fit([samples_between(each, gap, share) for each in recordings])
        for gap in GAPS
        for share in SHARES
    ]
    return {"ahead": ahead, "between": between}


def fit_noise(tracks: Sequence[Piece]) -> CaKalmanParameters:
    """Return the parameters of ``ca_kalman`` under which the tracks are most likely, to three digits."""

    def cost(logs: Array) -> float:
        jerk_px, measured_px = np.exp(logs)
        return -sum(log_likelihood(track, CaKalmanParameters(jerk_px, measured_px)) for track in tracks)

    found = minimize(cost, np.log([0.01, 0.5]), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-2})
    jerk_px, measured_px = (float(f"{value:.3g}") for value in np.exp(found.x))
    return CaKalmanParameters(jerk_px, measured_px)


def fit_decay(tracks: Sequence[Piece]) -> float:
    """Return the time constant (frames) of damped velocity that suits the tracks best, to three digits."""
    method = DampedVelocity(DampedParameters(), np.random.default_rng(0))
    method.learn(tracks)
    return float(f"{method.decay_frames:.3g}")


def write(path: Path, content: dict[str, Any], command: str) -> Path:
    """Write what was learnt to one of the files that are shipped; return its path."""
    write_atomic(path, json.dumps(content | {"command": command}) + "\n")
    return path


def _fit(parts: Sequence[Samples]) -> dict[str, list[float]]:
    regression = first_fit(_joined(parts))
    return {
        name: [float(f"{value:.5g}") for value in values]
        for name, values in (("weights", regression.weights), ("spread", regression.spread))
    }


def _joined(parts: Sequence[Samples]) -> Samples:
    """Return all samples; each recording has the same weight."""
    names = ("features", "step", "scales", "fold")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    counts = np.array([len(part.step) for part in parts])
    weight = np.repeat(100.0 / np.maximum(counts, 1), counts)
    return Samples(**joined, weight=weight, independent=sum(part.independent for part in parts), added=parts[0].added)
