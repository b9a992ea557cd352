"""``frameout train``: train a policy that follows."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import COUNT, FOLDER, ONE_NAME, SEEDS, VALUES, development_seeds, seed_range
from benchmarks.commands.progress import progress_bar
from benchmarks.learning.error_models import make_error_model, save_error_model
from benchmarks.learning.model_check import as_table, model_check
from benchmarks.learning.settings import Algorithm, Corrects, Training
from benchmarks.learning.training import train
from benchmarks.run.experiment import make_folder
from scenarios import catalog
from scenarios.envs.pictureless.vector_env import Starts
from scenarios.envs.reward import Reward
from scenarios.envs.settings import FollowSettings
from trackers.controllers.catalogue import controllers

_RUNS = "runs"


@dataclass(frozen=True)
class Train:
    """Train a policy in an env, with stable-baselines3; stopped at any moment, the same command goes on.

    By default in the env without pictures, where a fitted model of the tracker's errors stands for picture and
    tracker; `frameout bench follow --controllers policy:OUT/policy.json` judges it in the rendered one. OUT gets
    policy.json and policy.safetensors (no pickle), checkpoints, and curves for TensorBoard.

    Attributes:
        env: env id, see `frameout list`.
        algorithm: ppo, or sac (off-policy).
        steps: of all envs together.
        tracker: in the loop (default: the env's).
        preset: of the scenario.
        controller: the one that the policy corrects; none: the policy steers alone.
        controller_values: of its parameters, other than those it was tuned to, e.g. gain_per_s 0.8.
        corrects: when it corrects: always, or while the tracker does not see the target (unseen).
        correction_share: the largest correction, as a share of the command's limit.
        reward: weights of the reward's terms.
        pictures: train in the rendered env.
        envs: number of envs that run together (default: 256 without pictures, one for each core with them).
        episodes: planned for the env without pictures, about a second each; they are kept.
        starts: where episodes begin without pictures: episodes (on frame 0), or frame-outs (a little before the target
            is about to be lost).
        episode_steps: episodes are cut to so many steps.
        seed: of everything random.
        check_model: episodes A:B in which controllers are run with pictures and without, to be shown side by side,
            instead of training: how far the model of the tracker's errors is to be trusted.
        fit_model: episodes A:B that are run with pictures, and to which the model of the tracker's errors is fitted
            anew, instead of training; it takes the place of the one that there is.
        out: folder (default: results/policies/ENV).
    """

    env: tyro.conf.Positional[str] = "frameout/RoadTownFollow-v1"
    algorithm: Algorithm = "ppo"
    steps: Annotated[int, COUNT] = 4_000_000
    tracker: Annotated[str, ONE_NAME] = ""
    preset: str = "standard"
    controller: str = "reentry"
    controller_values: Annotated[dict[str, float], VALUES] = field(default_factory=dict)
    corrects: Corrects = "always"
    correction_share: float = 0.5
    reward: Reward = field(default_factory=Reward)
    pictures: bool = False
    envs: Annotated[int, COUNT] = 0
    episodes: Annotated[int, COUNT] = 256
    starts: Starts = "episodes"
    episode_steps: int = 300
    seed: int = 0
    check_model: Annotated[str, SEEDS] = ""
    fit_model: Annotated[str, SEEDS] = ""
    out: Annotated[Path | None, FOLDER] = None

    @property
    def training(self) -> Training:
        """Everything that the training depends on."""
        return Training(**{each.name: getattr(self, each.name) for each in dataclasses.fields(Training)})

    def run(self) -> int:
        """Train; return the exit status."""
        if self.fit_model and self.check_model:
            raise ValueError(f"fit_model: expected it without check_model, got {self.fit_model!r} with it")
        training = self.training
        out = self.out or Path("results") / "policies" / self.env.rsplit("/", 1)[-1]
        make_folder(out)
        settings = FollowSettings(training.scenario, training.tracker_name, preset=training.preset)
        if self.fit_model:
            return self._fit_model(settings, out / _RUNS)
        if self.check_model:
            return self._check_model(settings, out / _RUNS)
        with progress_bar(f"{self.env}, {self.algorithm}") as progress:
            path = train(training, out, progress)
        print(f"policy: {path}\njudge it: frameout bench follow --controllers policy:{path}")
        return 0

    def _fit_model(self, settings: FollowSettings, runs: Path) -> int:
        seeds = development_seeds(self.fit_model, "fit_model")
        with progress_bar("episodes with pictures") as progress:
            model = make_error_model(settings, seeds, runs, progress)
        print(f"model of the errors of {settings.tracker}: {save_error_model(model)}")
        return 0

    def _check_model(self, settings: FollowSettings, runs: Path) -> int:
        names = tuple(controllers(catalog.scenario(settings.scenario).carrier.name))
        seeds = seed_range(self.check_model, "check_model")
        with progress_bar("controllers with pictures and without") as progress:
            compared = model_check(settings, names, seeds, runs, progress)
        print(as_table(compared))
        return 0
