"""All that a training depends on."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from benchmarks.run.workers import cores
from scenarios import catalog
from scenarios.envs.pictureless.vector_env import Starts
from scenarios.envs.reward import Reward
from sim.checks import check
from trackers.controllers.catalogue import our_controller

_PICTURELESS_ENVS = 256
EPISODES = Path("results/episodes")
"""Folder of planned episodes for envs without pictures, kept for reuse."""
RUNS = Path("results/runs")
"""Folder of runs with pictures whose answers are played to several controllers, kept for reuse."""
Algorithm = Literal["ppo", "recurrent-ppo", "sac"]
Corrects = Literal["always", "unseen"]


_SET_BY_TRAINING = {"observation", "progress"}
"""Keywords of the env: a policy sees the belief, and the progress is that of the training."""


@dataclass(frozen=True)
class Training:
    """Everything that a training depends on.

    Attributes:
        env: env id.
        algorithm: ``ppo``, ``recurrent-ppo`` (the policy remembers, by an LSTM), or ``sac`` (off-policy).
        steps: of all envs together.
        tracker: in the loop; without pictures its error model.
        preset: of the scenario; empty: the env's.
        controller: the one that the policy corrects; empty: ours for the carrier; ``none``: the policy steers alone.
        controller_values: parameter values in place of the tuned ones.
        corrects: when it corrects: ``always``, or while the target is ``unseen``.
        correction_share: the largest correction, as a share of the command's limit.
        action_repeat: pictures that an action holds. history: number of earlier pictures that the policy sees the
            changes of all features since.
        learning_rate: of the first update; it falls linearly to 0.
        reward: weights of its terms.
        pictures: train in the rendered env; otherwise in the one without pictures.
        envs: number of envs that run together; 0: 256 without pictures, one for each core with them.
        episodes: number planned for the env without pictures, with seeds from 0.
        starts: first frame without pictures: frame 0 (``episodes``), as in the rendered env, or shortly before the
            target is likely to be lost (``frame-outs``).
        episode_steps: maximum number of steps of an episode; None: all of them, as are scored.
        seed: of all random numbers.
        env_kwargs: further keywords of the env, see ``FollowSettings``, e.g. ``{"link": "delayed"}``.
        evaluations: how often the policy is evaluated with pictures, the last time at the end.
        modules: users' own modules, imported first in every process.
    """

    env: str
    algorithm: Algorithm = "ppo"
    steps: int = 12_000_000
    tracker: str = ""
    preset: str = ""
    controller: str = ""
    controller_values: dict[str, float] = field(default_factory=dict)
    corrects: Corrects = "always"
    correction_share: float = 1.0
    action_repeat: int = 4
    history: int = 6
    learning_rate: float = 5e-4
    reward: Reward = field(default_factory=Reward)
    pictures: bool = False
    envs: int = 0
    episodes: int = 256
    starts: Starts = "episodes"
    episode_steps: int | None = None
    seed: int = 0
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    evaluations: int = 2
    modules: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        catalog.check_env(self.env)
        for name in ("steps", "episodes", "episode_steps", "action_repeat"):
            value = getattr(self, name)
            check(name, value is None or value >= 1, "a whole number >= 1", value)
        check("envs", self.envs >= 0, "a whole number >= 0", self.envs)
        check("evaluations", self.evaluations >= 0, "a whole number >= 0", self.evaluations)
        check("history", self.history >= 0, "a whole number >= 0", self.history)
        check("learning_rate", 0.0 < self.learning_rate < 1.0, "a number in (0, 1)", self.learning_rate)
        taken = sorted(self.env_kwargs.keys() & (self._keywords.keys() | _SET_BY_TRAINING))
        check("env_kwargs", not taken, "none that the training sets by an option of its own", ", ".join(taken))
        whole = self.starts == "episodes" or not self.pictures
        check("starts", whole, "episodes with pictures, which begin on frame 0", repr(self.starts))
        alone = self.controller != "none" or not self.controller_values
        check("controller_values", alone, "none with controller none", repr(self.controller_values))
        check("seed", self.seed >= 0, "a whole number >= 0", self.seed)

    @property
    def env_count(self) -> int:
        """Number of envs that run together."""
        return self.envs or (cores(None) if self.pictures else _PICTURELESS_ENVS)

    @property
    def scenario(self) -> str:
        """Catalogue id of the env's scenario."""
        return catalog.envs()[self.env][0]

    @property
    def tracker_name(self) -> str:
        """The tracker, by default that of the env."""
        return self.tracker or catalog.envs()[self.env][1]

    @property
    def preset_name(self) -> str:
        """The preset, by default that of the env."""
        return self.preset or catalog.env_preset(self.scenario)

    @property
    def controller_name(self) -> str:
        """The controller that the policy corrects, by default ours for the carrier; ``none`` without one."""
        return self.controller or our_controller(catalog.scenario(self.scenario).carrier.name)

    @property
    def resolved(self) -> dict[str, Any]:
        """What the training depends on, with the names in place of defaults, and without what it has no use for."""
        known = {"preset": self.preset_name, "controller": self.controller_name, "tracker": self.tracker_name}
        return {name: value for name, value in (asdict(self) | known).items() if name != "evaluations"}

    @property
    def env_keywords(self) -> dict[str, Any]:
        """Keywords of ``gym.make`` and ``gym.make_vec`` for this training's env."""
        return self._keywords | self.env_kwargs

    @property
    def _keywords(self) -> dict[str, Any]:
        alone = self.controller_name == "none"
        steering: dict[str, Any] = {"action": "command"}
        if not alone:
            steering = {
                "action": "correction",
                "controller": self.controller_name,
                "controller_values": self.controller_values,
                "corrects": self.corrects,
                "correction_share": self.correction_share,
            }
        # A difficulty stands in place of a preset.
        preset = None if "difficulty" in self.env_kwargs else self.preset_name
        return {"preset": preset, "tracker": self.tracker_name, "reward": self.reward, **steering}
