"""Registration of the envs with Gymnasium.

The catalogue registers each env with its scenario, and so does every import of ``scenarios``. It takes Gymnasium, a
tenth of a second; the envs themselves are imported when one is made.
"""

from __future__ import annotations

import gymnasium as gym
from gymnasium.envs.registration import ENV_ID_RE

from sim.checks import check


def register_env(env_id: str, scenario: str, tracker: str) -> None:
    """Register the env of a scenario with a default tracker. Raises ValueError for an id that Gymnasium cannot read."""
    good = ENV_ID_RE.fullmatch(env_id) is not None
    check("env_id", good, "a name with its version, such as frameout/Mine-v1", repr(env_id))
    gym.register(
        id=env_id,
        entry_point="scenarios.envs.follow_env:FollowEnv",
        vector_entry_point="scenarios.envs.vectors:follow_vector_env",
        kwargs={"scenario": scenario, "tracker": tracker},
    )
