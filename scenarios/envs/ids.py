"""The env ids, and the scenario each of them is about."""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

FOLLOW_ENVS = {
    "frameout/RoadTownFollow-v1": ("road-town-v1", "mosaic_graph_pf"),
    "frameout/StereoFollow-v1": ("stereo-follow-v1", "stereo_people"),
}
"""Env id -> catalogue id, and the tracker in the loop if no other is asked for."""
DEFAULT_EPISODE_STEPS = 299
"""Steps of an episode of 300 frames, the presets' usual length."""


def register_envs() -> None:
    """Make every id known; calling it again changes nothing."""
    for env_id, (scenario, tracker) in FOLLOW_ENVS.items():
        if env_id not in registry:
            register(
                id=env_id,
                entry_point="scenarios.envs.follow_env:FollowEnv",
                vector_entry_point="scenarios.envs.vector_entry:follow_vector_env",
                max_episode_steps=DEFAULT_EPISODE_STEPS,
                kwargs={"scenario": scenario, "tracker": tracker},
            )
