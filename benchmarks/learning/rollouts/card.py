"""The README.md of a set of rollouts: what it holds, how it is read, and how it is played again."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.contract.text import ranges_text
from benchmarks.learning.rollouts.recording import PRIVILEGED, EpisodeFile, options_of
from benchmarks.learning.rollouts.request import Rollouts
from benchmarks.show.page import page_environment
from benchmarks.show.tables import markdown_table
from scenarios import catalog
from scenarios.envs.truth_info import INFO, truth_keys
from trackers.belief.features import MEANINGS
from trackers.controllers.catalogue import POLICY

_HEADS = {"lerobot": "data/*/*.parquet", "parquet": "data/*.parquet", "minari": ""}
"""Format -> the files that the library ``datasets`` reads."""
_OF_STEPS = {
    "reward": "what the step returned",
    "terminated": "the step ended the episode: the target was lost",
    "truncated": "the step was the episode's last one",
}


@dataclass(frozen=True)
class Made:
    """What a set holds.

    Attributes:
        episodes, steps: numbers.
        mean_return: mean of the episodes' sums of rewards. time_in_view: mean share of their steps, see ``INFO``.
    """

    episodes: int
    steps: int
    mean_return: float
    time_in_view: float


def card_text(rollouts: Rollouts, first: EpisodeFile, made: Made) -> str:
    """Return the card."""
    scenario = catalog.scenario(catalog.envs()[rollouts.env][0])
    env = rollouts.make()
    env.close()
    kind: Any = scenario.truth
    info = {**INFO, **truth_keys(kind)}
    names = [name.removeprefix(PRIVILEGED) for name in first.names if name.startswith(PRIVILEGED)]
    features = [[str(place), f"`{name}`", meaning] for place, (name, meaning) in enumerate(MEANINGS.items())]
    axes = [
        [str(place), f"`{axis.name}`", f"{axis.limit:g}"]
        for place, axis in enumerate(env.unwrapped.carrier.axes)  # type: ignore[attr-defined]
    ]
    keywords = {"preset": rollouts.preset} if rollouts.preset else {}
    return (
        page_environment(__file__, autoescape=False)
        .get_template("card.md.jinja")
        .render(
            rollouts=rollouts,
            made=made,
            scenario=scenario,
            seeds=ranges_text(range(*rollouts.seeds)),
            command=command_of(rollouts),
            data_files=_HEADS[rollouts.format],
            dataset_id=dataset_id(rollouts),
            options=options_of(rollouts.seeds[0]),
            keywords={"tracker": rollouts.tracker, **keywords, **rollouts.env_kwargs},
            features=markdown_table(("place", "feature", "meaning"), features, 3),
            axes=markdown_table(("place", "axis", "limit of its unit"), axes, 2),
            infos=markdown_table(("name", "meaning"), [[f"`{name}`", info[name][2]] for name in names], 2),
            editions=", ".join(f"{part} {made_by}" for part, made_by in rollouts.editions.items()),
        )
    )


def dataset_id(rollouts: Rollouts) -> str:
    """Return the id of a Minari set: the env and who steered, a policy by the name of its file."""
    words = re.sub(r"\W+", "_", Path(rollouts.controller.removeprefix(POLICY)).stem).strip("_")
    return f"{rollouts.env}/{words or 'policy'}-v0"


def command_of(rollouts: Rollouts) -> str:
    """Return the command that makes the set again."""
    words = ["frameout", "rollout", rollouts.env, "--controller", rollouts.controller]
    words += ["--seeds", ":".join(map(str, rollouts.seeds)), "--format", rollouts.format]
    words += ["--pictures", rollouts.pictures, "--tracker", rollouts.tracker]
    words += ["--preset", rollouts.preset] if rollouts.preset else []
    words += ["--env-kwargs", json.dumps(rollouts.env_kwargs)] if rollouts.env_kwargs else []
    words += ["--modules", *rollouts.modules] if rollouts.modules else []
    return shlex.join([*words, "--out", "FOLDER"])
