"""Memory of a vector env's processes over very many steps and episodes."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.processes import EnvProcesses
from tools.speed.env_stepping import env_keywords

LARGEST_GROWTH = 0.05
_MEBIBYTE = 2**20


@dataclass(frozen=True)
class SoakSample:
    """One sample of a soak.

    Attributes:
        steps, episodes, seconds: since the beginning, all envs together.
        rss_mib: resident memory of this process and of every env's, in MiB.
    """

    steps: int
    episodes: int
    seconds: float
    rss_mib: tuple[float, ...]


def soak(
    preset: str, steps: int, num_envs: int, report: Callable[[SoakSample], None], samples: int = 40
) -> list[SoakSample]:
    """Step with random actions, resets included, and return evenly spread samples.

    Args:
        steps: of all envs together, at least ``samples`` for each env.
        report: called with each sample at once.
    """
    rounds = -(-steps // num_envs)
    every = max(rounds // samples, 1)
    taken: list[SoakSample] = []
    rng = np.random.default_rng(0)
    with closing(EnvProcesses([partial(FollowEnv, **env_keywords(preset))] * num_envs)) as envs:
        ids = (os.getpid(), *(process.pid or 0 for process in envs.processes))
        began, episodes = time.perf_counter(), num_envs
        envs.reset(seed=0)
        for k in range(1, rounds + 1):
            *_, terminated, truncated, _ = envs.step(rng.uniform(-1, 1, envs.action_space.shape or ()))
            episodes += int((terminated | truncated).sum())
            if k % every == 0 or k == rounds:
                rss_mib = tuple(resident_mib(each) for each in ids)
                taken.append(SoakSample(k * num_envs, episodes, time.perf_counter() - began, rss_mib))
                report(taken[-1])
    return taken


def growth(samples: list[SoakSample]) -> float:
    """Return the relative growth of the total memory from the second fifth of the steps to the last.

    Means, since large towns need more memory. In the first fifth caches of meshes and kernels fill.
    """
    total_mib = np.array([sum(each.rss_mib) for each in samples])
    share = np.array([each.steps for each in samples]) / samples[-1].steps
    early, late = (share > 0.2) & (share <= 0.4), share > 0.8
    return float(total_mib[late].mean() / total_mib[early].mean() - 1.0)


def resident_mib(process_id: int) -> float:
    """Return a process's resident memory in MiB."""
    pages = int(Path(f"/proc/{process_id}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / _MEBIBYTE
