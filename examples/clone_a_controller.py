"""Clone a controller from its rollouts (behaviour cloning), and score the clone beside its teacher on fresh episodes.

Needs `pip install 'frameout[data,train]'`. The teacher knows the gusts to come and keeps the car in view, so nothing
shows the clone what to do once it is far off: with `--episodes 4` `omniscient` sees the car 100 % of the time,
`reentry` 93, the clone 49. DAgger asks the teacher about the clone's own states (Ross, Gordon and Bagnell, 2011)::

    frameout rollout frameout/RoadTownFollow-v3 --controller omniscient --preset quick --pictures none \
        --episodes 24 --out sets/teacher
    python examples/clone_a_controller.py sets/teacher --out results/clone
"""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pandas as pd
import torch
import tyro
from numpy.typing import NDArray
from torch import nn

from benchmarks import bench
from scenarios import catalog
from trackers.belief.features import FEATURES, FeatureHistory
from trackers.controllers.catalogue import our_controller
from trackers.controllers.policy import LARGEST_INPUT, Policy, save_policy

HISTORY, WIDTHS, BATCH, IGNORED = 6, (128, 64), 256, 1e6


def samples_of(folder: Path) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return what a policy would see at each step of a set (N, in), and what the teacher did then (N, A)."""
    steps = pd.read_parquet(folder / "data", columns=["episode_seed", "observation.track", "action"])
    seen, done = [], []
    for _, episode in steps.dropna(subset="action").groupby("episode_seed"):
        history = FeatureHistory(1, HISTORY)
        for number, features in enumerate(episode["observation.track"]):
            (history.add if number else history.begin)(features[None])
            seen.append(history.numbers()[0])
        done.extend(episode["action"])
    return np.array(seen), np.stack(done)


def scale_of(seen: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return mean and deviation (in,) of the input. The latest commands are not looked at: a clone that sees them
    learns to repeat them (de Haan, Jayaraman and Levine, Causal confusion in imitation learning, 2019)."""
    is_command = np.array([name.startswith("command_") for name in FEATURES] * (1 + HISTORY))
    return seen.mean(axis=0), np.where(is_command, IGNORED, np.maximum(seen.std(axis=0), 0.01)).astype(np.float32)


def train(seen: NDArray[np.float32], done: NDArray[np.float32], steps: int, seed: int) -> tuple[nn.Sequential, float]:
    """Return a network from standardised input to action, and its mean squared error over the last steps."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    sizes = (seen.shape[1], *WIDTHS, done.shape[1])
    layers = [part for a, b in itertools.pairwise(sizes) for part in (nn.Linear(a, b), nn.Tanh())]
    network = nn.Sequential(*layers[:-1])
    adam = torch.optim.AdamW(network.parameters(), weight_decay=0.1)
    rate = torch.optim.lr_scheduler.OneCycleLR(adam, 2e-3, steps)
    inputs, actions, losses = torch.from_numpy(seen), torch.from_numpy(done), []
    for _ in range(steps):
        batch = torch.randint(len(inputs), (BATCH,))
        loss = (network(inputs[batch]) - actions[batch]).square().mean()
        adam.zero_grad()
        loss.backward()
        adam.step()
        rate.step()
        losses.append(loss.item())
    return network, float(np.mean(losses[-100:]))


def main(rollouts: tyro.conf.Positional[Path], out: Path, episodes: int = 8, steps: int = 4000, seed: int = 0) -> None:
    """Clone the controller of ``rollouts``, a Parquet set, and score it on episodes from seed 9,000 on."""
    told = json.loads((rollouts / "rollouts.json").read_text())
    seen, done = samples_of(rollouts)
    mean, deviation = scale_of(seen)
    network, error = train(np.clip((seen - mean) / deviation, -LARGEST_INPUT, LARGEST_INPUT), done, steps, seed)
    print(f"{len(seen)} steps of {told['controller']}; mean squared error {error:.4f}")
    layers = (tuple(getattr(layer, part).detach().numpy() for layer in network[::2]) for part in ("weight", "bias"))
    carrier = catalog.scenario(scene := catalog.envs()[told["env"]][0]).carrier
    # It steers alone, at all times, on every picture.
    form = (None, 1.0, "always", FEATURES, HISTORY, 1, "tanh", "clip")
    made = {"cloned": told["controller"], "editions": told["editions"], "steps": steps, "seed": seed}
    policy = Policy(told["env"], carrier, told["tracker"], *form, mean, deviation, *layers, made=made)  # type: ignore[arg-type]
    clone = f"policy:{save_policy(policy, out / 'clone.json')}"
    controllers = list(dict.fromkeys([told["controller"], our_controller(carrier.name), clone]))
    assert told["env_kwargs"].keys() <= {"link"}, "the set's env differs from the suite's in more than its link"
    how = {"scenario": scene, "trackers": told["tracker"], "controllers": controllers, "out": out, **told["env_kwargs"]}
    preset = told["preset"] or catalog.env_preset(scene)
    results = bench("follow", seeds=range(9000, 9000 + episodes), preset=preset, **how)
    shown = results.summary().query("metric in ('time_seen', 'losses_per_minute', 'effort')")
    print(shown.pivot(index="controller", columns="metric", values="mean").loc[controllers].round(3).to_string())


if __name__ == "__main__":
    tyro.cli(main)
