"""Worlds to follow targets in. Importing this makes the env ids known to Gymnasium."""

from scenarios.envs.ids import register_envs

register_envs()
