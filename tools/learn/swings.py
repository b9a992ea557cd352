"""``python -m tools learn-swings``: learn how a swing of a helicopter's camera goes on from how it began.

The network of ``trackers.controllers.swing_forecast`` is fitted to the measured tilts of flights without pictures, by
the likelihood of Gaussian errors whose standard deviations it answers too (Nix and Weigend, 1994). The air does not
depend on where the helicopter flies, so one that hovers will do.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cli.arguments import DevelopmentSeeds, seeds_text
from benchmarks.learning.training import EPISODES
from benchmarks.run.packages import check_packages
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from sim.checks import check
from tools.learn.swims import TRACKERS, write
from trackers.controllers.swing_forecast import (
    FORECAST_FILE,
    HISTORY,
    LEAST_LOG,
    MOST_LOG,
    foresee,
    inputs_of,
    read_forecast,
)

FORECAST_PATH = TRACKERS / "controllers" / FORECAST_FILE
AHEAD = np.array([2, 4, 6, 9, 12, 16, 20, 25, 30, 38])
"""Numbers of frames after which a forecast is learnt."""
_SCENARIO, _TRACKER, _RATE_HZ = "road-town-v2", "mosaic_graph_pf", 15.0
_ROUNDS, _BATCH, _LEARNING_RATE = 6000, 1024, 3e-3
_LEAST_FRAMES = 10
"""At the end of an episode the last tilt stands for later ones, if there are so many left."""


@dataclass(frozen=True)
class LearnSwings:
    """Learn how swings of the camera go on; write it to the controllers' file.

    Attributes:
        seeds: flights A to B - 1, below 10,000.
        fresh: flights on which the forecast is tried.
        units: number of units in each of the two layers.
    """

    seeds: DevelopmentSeeds = range(256)
    fresh: DevelopmentSeeds = range(1000, 1128)
    units: int = 16
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        check("units", self.units >= 1, "a whole number >= 1", self.units)
        check_packages(["torch"], "train")
        learnt = learn_swings(measured_tilts(self.seeds), self.units)
        errors = forecast_errors(learnt, measured_tilts(self.fresh))
        shown = {
            "fresh": seeds_text(self.fresh),
            "error": [float(f"{each:.3g}") for each in errors["forecast"]],
            "error_if_it_stays": [float(f"{each:.3g}") for each in errors["stays"]],
        }
        chosen = f"--seeds {seeds_text(self.seeds)} --fresh {seeds_text(self.fresh)} --units {self.units}"
        print(write(FORECAST_PATH, learnt | shown, f"python -m tools learn-swings {chosen}"))
        return 0


def measured_tilts(seeds: range) -> NDArray[np.float64]:
    """Return the measured tilts (E, T, 2), ahead and right, of flights of ``road-town`` without pictures."""
    envs = PicturelessVectorEnv(len(seeds), _SCENARIO, _TRACKER, seeds=seeds, cache=EPISODES, action="command")
    envs.reset(seed=0, options={"episode_seed": np.array(seeds)})
    nothing, tilts = np.zeros(envs.action_space.shape or ()), [_tilts(envs)]
    # With the last step other episodes begin.
    for _ in range(envs.bank.frame_count - 2):
        envs.step(nothing)
        tilts.append(_tilts(envs))
    envs.close()
    return np.stack(tilts, axis=1)


def _tilts(envs: PicturelessVectorEnv) -> NDArray[np.float64]:
    sightings = envs.sightings
    return np.stack([sightings["axis_ahead_m"], sightings["axis_right_m"]], axis=-1) / sightings["height_m"][:, None]


def lessons(tilts: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what the network sees of tilts (E, T, 2) at each time (N, I), and the changes that follow (N, K, 2), in
    the axes that it answers in.
    """
    last = tilts.shape[1] - 1
    seen, follows = [], []
    for flight in tilts:
        for t in range(HISTORY, last + 1 - _LEAST_FRAMES):
            inputs = np.zeros(1 + 2 * HISTORY)
            c, s = inputs_of(np.ascontiguousarray(flight[t - HISTORY : t + 1][::-1]), inputs)
            change = flight[np.minimum(t + AHEAD, last)] - flight[t]
            seen.append(inputs)
            follows.append(change @ np.array([[c, -s], [s, c]]))
    return np.array(seen), np.array(follows)


def learn_swings(tilts: NDArray[np.float64], units: int) -> dict[str, Any]:
    """Return the network's numbers, as in its file."""
    import torch

    torch.manual_seed(0)
    torch.set_num_threads(1)
    seen, follows = (torch.tensor(each, dtype=torch.float32) for each in lessons(tilts))
    count = len(AHEAD)
    mirror = torch.ones(seen.shape[1])
    mirror[2::2] = -1.0
    sizes = (seen.shape[1], units, units, 3 * count)
    layers = [torch.nn.Linear(*each) for each in pairwise(sizes)]
    network = torch.nn.Sequential(layers[0], torch.nn.Tanh(), layers[1], torch.nn.Tanh(), layers[2])
    adam = torch.optim.Adam(network.parameters(), _LEARNING_RATE)
    schedule = torch.optim.lr_scheduler.LinearLR(adam, 1.0, 1e-3, _ROUNDS)
    for _ in range(_ROUNDS):
        few = torch.randint(len(seen), (_BATCH,))
        # As ``foresee`` puts its answers together.
        both = torch.cat([seen[few], seen[few] * mirror, torch.zeros_like(seen[:1])])
        answer = network(both).reshape(-1, count, 3)
        own, mirrored, still = answer[:_BATCH], answer[_BATCH:-1], answer[-1:]
        along = 0.5 * (own[..., 0] + mirrored[..., 0]) - still[..., 0]
        across = 0.5 * (own[..., 1] - mirrored[..., 1])
        spread = 0.5 * sum(each[..., 2].clamp(LEAST_LOG, MOST_LOG).exp() for each in (own, mirrored))
        squared = (torch.stack([along, across], dim=-1) - follows[few]).square().sum(dim=-1)
        loss = (0.5 * squared / spread**2 + 2.0 * spread.log()).mean()
        adam.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        adam.step()
        schedule.step()
    learnt: dict[str, Any] = {"step_s": round(1.0 / _RATE_HZ, 6), "at_s": np.round(AHEAD / _RATE_HZ, 6).tolist()}
    for place, each in enumerate(layers, 1):
        for name, numbers in ((f"weights_{place}", each.weight), (f"bias_{place}", each.bias)):
            exact = numbers.detach().double().numpy()
            learnt[name] = np.vectorize(lambda number: float(f"{number:.5g}"))(exact).tolist()
    return learnt


def forecast_errors(learnt: dict[str, Any], tilts: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Return root mean square errors (K,) of the ``forecast``, and of a tilt that ``stays``, after ``AHEAD`` frames."""
    network, last = read_forecast(learnt), tilts.shape[1] - 1
    expected, spreads = np.zeros((len(AHEAD), 2)), np.zeros(len(AHEAD))
    errors: dict[str, list[NDArray[np.float64]]] = {"forecast": [], "stays": []}
    for flight in tilts:
        for t in range(HISTORY, last + 1 - _LEAST_FRAMES):
            foresee(np.ascontiguousarray(flight[t - HISTORY : t + 1][::-1]), network, network.at_s, expected, spreads)
            true = flight[np.minimum(t + AHEAD, last)]
            errors["forecast"].append(expected - true)
            errors["stays"].append(flight[t] - true)
    return {name: np.sqrt((np.array(each) ** 2).mean(axis=(0, 2))) for name, each in errors.items()}
