"""The env ids over a world without a renderer, where resets are cheap."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.stereo_follow.robot import ROBOT
from tests.fakes_scenario import FAKE_TOWN
from tests.fakes_trackers import Knowing, NoParameters

IDS = ("frameout/RoadTownFollow-v3", "frameout/StereoFollow-v3")
FRAMES = 40
FLOWN, DRIVEN = replace(FAKE_TOWN, id="road-town-v2"), replace(FAKE_TOWN, id="stereo-follow-v2", carrier=ROBOT)


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let both ids mean cars on circles, below a helicopter and below what moves like the robot."""
    worlds = {FLOWN.id: "FLOWN", DRIVEN.id: "DRIVEN"}
    known = [entry for entry in catalog._ENTRIES if entry.id in worlds]
    entries = tuple(replace(entry, place=f"{__name__}:{worlds[entry.id]}") for entry in known)
    monkeypatch.setattr(catalog, "_ENTRIES", entries)


def keywords(**others: Any) -> dict[str, Any]:
    """Return the keywords of an env in the stand-in's world, with a tracker that is right except for noise."""
    return {"preset": "tiny", "changes": {"frame_count": FRAMES}, "observation": "both", "tracker": knowing()} | others


def knowing() -> Knowing:
    """Return a tracker that knows the circle."""
    return Knowing(NoParameters(), np.random.default_rng(0))


def make(env_id: str = IDS[0], **others: Any) -> FollowEnv:
    env = gym.make(env_id, **keywords(**others)).unwrapped
    assert isinstance(env, FollowEnv)
    return env


def fresh(tracker: type) -> Any:
    return tracker(NoParameters(), np.random.default_rng(0))
