"""What a set of rollouts is of: env, controller and episodes, its format, and what made them."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import gymnasium as gym

from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.contract.suite import controllers_suite
from benchmarks.run.editions import Editions, controller_edition, package_versions, scene_edition, tracker_edition
from benchmarks.run.packages import check_packages
from benchmarks.run.selection import tracker_named
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from sim.checks import check, check_choice
from trackers.controllers.catalogue import ControllerEntry, controller_entry, our_controller

Format = Literal["lerobot", "minari", "parquet"]
Pictures = Literal["none", "h264", "jpeg", "png", "raw"]
PICTURES: Mapping[Format, tuple[Pictures, ...]] = {
    "lerobot": ("h264", "none"),
    "minari": ("none", "raw"),
    "parquet": ("jpeg", "png", "none"),
}
"""Format -> how it can hold pictures, by default the first."""
_WRITERS: Mapping[Format, tuple[str, ...]] = {"lerobot": ("av",), "minari": ("h5py", "minari"), "parquet": ()}
"""Packages that its bytes depend on, beside those of every format."""
_TAKEN = ("action", "observation", "preset", "render_mode", "tracker", "worlds")
"""Keywords of the env that are set by an option, or that rollouts have no use for: each has its own world."""


@dataclass(frozen=True)
class Rollouts:
    """A set of rollouts as it is ordered.

    Attributes:
        env: env id.
        seeds: first and last + 1 of the episodes, in the catalogue: ``episode_seed`` of ``reset``.
        format: of the set, see ``PICTURES``.
        controller: name, or ``policy:FILE``; empty: ours for the carrier.
        pictures: how they are stored; empty: as the format usually does.
        tracker: name; empty: that of the env.
        preset: of the scenario; empty: the env's.
        env_kwargs: further keywords of the env.
        modules: users' own modules.
    """

    env: str
    seeds: tuple[int, int]
    format: Format
    controller: str = ""
    pictures: Pictures | Literal[""] = ""
    tracker: str = ""
    preset: str = ""
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)
    modules: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Fill in what is empty. Raises ValueError for a value that is not possible, and for missing packages."""
        catalog.check_env(self.env)
        check("seeds", 0 <= self.seeds[0] < self.seeds[1], "A:B with 0 <= A < B", ":".join(map(str, self.seeds)))
        of_test = {seed in TEST_SPLIT for seed in range(*self.seeds)}
        wanted = f"all of the test split, which is {TEST_SPLIT.start}:{TEST_SPLIT.stop}, or none"
        check("seeds", len(of_test) == 1, wanted, ":".join(map(str, self.seeds)))
        check_choice("format", self.format, PICTURES)
        check_packages(("fsspec", "pyarrow", *_WRITERS[self.format]), "data")
        scenario, usual = catalog.envs()[self.env]
        filled = {
            "controller": self.controller or our_controller(catalog.scenario(scenario).carrier.name),
            "pictures": self.pictures or PICTURES[self.format][0],
            "tracker": self.tracker or usual,
        }
        for name, value in filled.items():
            object.__setattr__(self, name, value)
        check_choice("pictures", self.pictures, PICTURES[self.format])
        taken = [name for name in _TAKEN if name in self.env_kwargs]
        check("env_kwargs", not taken, f"none of {', '.join(_TAKEN)}", ", ".join(taken))
        self.make().close()
        varies = self.format == "lerobot" and "rate_hz" in self.env_kwargs.get("randomise", ())
        check("env_kwargs", not varies, "a fixed rate_hz for lerobot", "randomise of it")
        _ = self.entry

    @property
    def keywords(self) -> dict[str, Any]:
        """Keywords of ``gym.make``."""
        own = {"preset": self.preset} if self.preset else {}
        observation = "track" if self.pictures == "none" else "both"
        return {"tracker": self.tracker, "observation": observation, **own, **self.env_kwargs}

    def make(self) -> gym.Env[Any, Any]:
        """Return a new env. Raises ValueError for keywords that it does not take."""
        return gym.make(self.env, disable_env_checker=True, **self.keywords)

    @property
    def entry(self) -> ControllerEntry:
        """The controller. Raises ValueError for an unknown one."""
        # It registers some of them.
        controllers_suite()
        return controller_entry(self.controller, catalog.scenario(catalog.envs()[self.env][0]).carrier.name)

    @property
    def split(self) -> Literal["train", "test"]:
        """The split that the episodes are of."""
        return "test" if self.seeds[0] in TEST_SPLIT else "train"

    @cached_property
    def editions(self) -> Editions:
        """What makes it, see ``benchmarks.run.editions``."""
        made = self.make()
        env: FollowEnv = made.unwrapped  # type: ignore[assignment]
        made.close()
        scenario = catalog.scenario(env.settings.scenario)
        return {
            "scene": scene_edition(scenario, env.settings.configuration({})),
            "tracker": tracker_edition(tracker_named(self.tracker)),
            **controller_edition(self.entry),
            **package_versions(env.settings.renderer),
            **{name: importlib.metadata.version(name) for name in ("pyarrow", *_WRITERS[self.format])},
        }

    def as_json(self) -> str:
        """Return it as JSON, with ``editions``."""
        told = dataclasses.asdict(self) | {"editions": self.editions}
        return json.dumps(told, indent=1) + "\n"
