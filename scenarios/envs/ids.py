"""Makes the env ids of the catalogue known to Gymnasium."""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

from scenarios import catalog

DEFAULT_EPISODE_STEPS = 299
"""Steps of an episode of 300 frames, the presets' usual length."""


def register_envs() -> None:
    """Make every id known; calling it again adds those that are new in the catalogue."""
    for env_id, (scenario, tracker) in catalog.envs().items():
        if env_id not in registry:
            register(
                id=env_id,
                entry_point="scenarios.envs.follow_env:FollowEnv",
                vector_entry_point="scenarios.envs.vector_entry:follow_vector_env",
                max_episode_steps=DEFAULT_EPISODE_STEPS,
                kwargs={"scenario": scenario, "tracker": tracker},
            )
