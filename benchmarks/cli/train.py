"""``frameout train``: train a policy."""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import (
    COUNT,
    FOLDER,
    JSON,
    ONE_NAME,
    VALUES,
    UsualDevelopmentSeeds,
    UsualSeeds,
    WithModules,
    keywords_of,
    seeds_text,
)
from benchmarks.contract.text import counted
from benchmarks.learning.evaluation import JUDGED, Evaluation, judging_command
from benchmarks.learning.settings import EPISODES, Algorithm, Corrects, Training
from benchmarks.learning.tracker_errors import make_error_model
from benchmarks.learning.training import Standing, needs_stable_baselines, train
from benchmarks.learning.without_pictures import as_table, model_check
from benchmarks.run.experiment import Progress
from benchmarks.run.result_folder import make_folder
from benchmarks.show.progress import progress_bar
from scenarios import catalog
from scenarios.envs.actions import check_values
from scenarios.envs.pictureless.bank import is_playable
from scenarios.envs.pictureless.error_model import error_model
from scenarios.envs.pictureless.vector_env import Starts
from scenarios.envs.reward import Reward
from scenarios.envs.settings import FollowSettings
from sim.checks import check
from trackers.controllers.catalogue import controller_entry, controllers

_RUNS = "runs"
_LINE_EVERY_S = 10.0


@dataclass(frozen=True)
class Train(WithModules):
    """Train a policy in an env with stable-baselines3. A run that was stopped continues with the same command.

    By default training is without pictures: a fitted model of the tracker's errors replaces picture and tracker.
    On the way it prints the mean reward of the latest episodes, the share of time with the target in view, and steps a
    second; now and then how the policy does with pictures, which runs in a process beside it; at the end the command
    that scores the policy so. OUT gets policy.json and policy.safetensors (no
    pickle), a checkpoint, and curves for TensorBoard.

    Attributes:
        env: env id, see `frameout list`.
        algorithm: ppo, recurrent-ppo (the policy remembers, by an LSTM), or sac (off-policy).
        steps: number of steps of all envs together (default: 12 million).
        tracker: name of the tracker (default: the env's); without pictures one with a model of its errors, see
            --fit-model.
        preset: one of the scenario's (default: the env's).
        controller: name of the controller that the policy corrects (default: ours for the carrier); none: the policy
            steers alone.
        controller_values: values of the controller's parameters in place of the tuned ones, e.g. gain_per_s 0.8.
        corrects: when the policy corrects: always, or while the tracker does not see the target (unseen).
        correction_share: the largest correction, as a share of the command's limit.
        action_repeat: number of pictures that an action of the policy holds; steps are counted in pictures.
        history: number of earlier pictures that the policy sees the changes of all features since.
        learning_rate: of the first update; it falls linearly to 0.
        reward: weights of the reward's terms, see `frameout list --envs`.
        pictures: train with pictures.
        envs: number of envs (default: 256 without pictures; with them one per core, each in a process of its own).
        episodes: number of episodes planned for training without pictures, a second to a few each; they are stored in
            results/episodes (default: 256).
        starts: first frame of episodes without pictures: episodes (frame 0), or frame-outs (shortly before the target
            is likely to be lost).
        episode_steps: maximum number of steps of an episode (default: all of them, as are scored).
        seed: of all random numbers.
        env_kwargs: further keywords of the env as JSON, see `frameout list --envs`, e.g. '{"link": "delayed"}'.
        evaluations: how often the policy is evaluated with pictures, the last time at the end.
        check_model: instead of training, run controllers in episodes A:B with pictures and without, and print both:
            this shows how accurate the model of the tracker's errors is.
        fit_model: instead of training, run episodes A:B with pictures, fit the model of the tracker's errors to them
            and replace the stored one.
        out: folder (default: results/policies/ENV).
    """

    env: tyro.conf.Positional[str] = catalog.DEFAULT_ENV
    algorithm: Algorithm = "ppo"
    steps: Annotated[int, COUNT] = 12_000_000
    tracker: Annotated[str, ONE_NAME] = ""
    preset: Annotated[str, ONE_NAME] = ""
    controller: Annotated[str, ONE_NAME] = ""
    controller_values: Annotated[dict[str, float], VALUES] = field(default_factory=dict)
    corrects: Corrects = "always"
    correction_share: float = 1.0
    action_repeat: Annotated[int, COUNT] = 4
    history: Annotated[int, COUNT] = 6
    learning_rate: float = 5e-4
    reward: Reward = field(default_factory=Reward)
    pictures: bool = False
    envs: Annotated[int, COUNT] = 0
    episodes: Annotated[int, COUNT] = 256
    starts: Starts = "episodes"
    episode_steps: Annotated[int | None, COUNT] = None
    seed: int = 0
    env_kwargs: Annotated[str, JSON] = "{}"
    evaluations: Annotated[int, COUNT] = 2
    check_model: UsualSeeds = None
    fit_model: UsualDevelopmentSeeds = None
    out: Annotated[Path | None, FOLDER] = None
    resumes = True

    @property
    def training(self) -> Training:
        """Everything that the training depends on."""
        given = {each.name: getattr(self, each.name) for each in dataclasses.fields(Training)}
        return Training(**given | {"env_kwargs": keywords_of(self.env_kwargs)})

    def run(self) -> int:
        """Train; return the exit status."""
        if self.fit_model and self.check_model:
            raise ValueError(f"fit_model: expected it without check_model, got {seeds_text(self.fit_model)} with it")
        training = self.training
        preset = catalog.scenario(training.scenario).configuration(training.preset_name)
        can = is_playable(training.scenario, preset) or training.pictures or bool(self.fit_model)
        check("pictures", can, f"--pictures, since {training.scenario} has no env without them", "none")
        if not (training.pictures or self.fit_model):
            error_model(training.scenario, training.tracker_name)
        if not (self.fit_model or self.check_model):
            needs_stable_baselines()
            if training.controller_name != "none":
                # Refused before the planning, which takes minutes.
                carrier = catalog.scenario(training.scenario).carrier.name
                check_values(controller_entry(training.controller_name, carrier), training.controller_values)
        out = self.out or Path("results") / "policies" / self.env.rsplit("/", 1)[-1]
        make_folder(out)
        settings = FollowSettings(training.scenario, training.tracker_name, preset=training.preset_name)
        if self.fit_model is not None:
            with progress_bar("episodes with pictures") as progress:
                path = make_error_model(settings, self.fit_model, out / _RUNS, progress)
            print(f"model of the errors of {settings.tracker}: {path}")
            return 0
        if self.check_model is not None:
            known = controllers(catalog.scenario(settings.scenario).carrier.name)
            names = tuple(name for name, entry in known.items() if entry.role != "oracle")
            with progress_bar("controllers with pictures and without") as progress:
                compared = model_check(settings, names, self.check_model, out / _RUNS, progress)
            print(as_table(compared))
            return 0
        if not training.pictures:
            print(
                f"planning {counted(training.episodes, 'episode')}, a second to a few for each that {EPISODES} lacks …",
                file=sys.stderr,
            )
        with progress_bar(f"{self.env}, {self.algorithm}") as progress:
            path = train(training, out, _Lines(progress))
        print(f"policy: {path}\njudge it beside a controller, with pictures:\n{judging_command(training, path)}")
        return 0


class _Lines:
    """Moves the progress bar, and prints a line above it now and then."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._next_s = 0.0

    def __call__(self, standing: Standing | Evaluation) -> None:
        if isinstance(standing, Evaluation):
            print(_with_pictures(standing), file=sys.stderr)
            return
        self._progress(standing.done, standing.of)
        if math.isfinite(standing.reward) and (time.monotonic() >= self._next_s or standing.done >= standing.of):
            print(_in_words(standing), file=sys.stderr)
            self._next_s = time.monotonic() + _LINE_EVERY_S


def _in_words(standing: Standing) -> str:
    return (
        f"{standing.done:,} steps: episode reward {standing.reward:.1f}, "
        f"in view {standing.time_in_view:.0%} of the time, {standing.steps_per_s:,.0f} steps/s"
    )


def _with_pictures(evaluation: Evaluation) -> str:
    low, high = 100.0 * evaluation.ci_low, 100.0 * evaluation.ci_high
    return (
        f"{evaluation.steps:,} steps, with pictures: target seen {evaluation.time_seen:.1%} of the time, "
        f"{100.0 * evaluation.difference:+.1f} ({low:.1f} to {high:.1f}) points beside {evaluation.controller}, "
        f"{counted(len(JUDGED), 'episode')}"
    )
