"""A bank of two short flights over an empty world, and an error model by hand."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from scenarios.envs.pictureless.bank import EpisodeBank
from scenarios.envs.pictureless.episode_state import LATENTS
from scenarios.envs.pictureless.error_model import CONDITION_FRAMES, KNOT_FRAMES, QUANTILE_Z, ErrorModel
from scenarios.road_town.presets import PRESETS, FrameOuts

FRAMES = 60
SEEDS = (3, 8)
CHANGES: dict[str, Any] = {"frame_count": FRAMES, "frame_outs": FrameOuts(count=(1, 1), frames=(1, 9))}
PRESET = dataclasses.replace(PRESETS["standard"], **CHANGES)
SETTINGS: dict[str, Any] = {
    "scenario": "road-town-v2",
    "tracker": "mosaic_graph_pf",
    "changes": CHANGES,
}


def bank() -> EpisodeBank:
    """Return two flights after cars that drive straight, with a gust that swings the view aside on frame 30."""
    target_m = np.zeros((2, FRAMES, 2))
    target_m[0, :, 0] = np.arange(FRAMES) * 9.0 / 15.0
    target_m[1, :, 1] = np.arange(FRAMES) * 7.0 / 15.0
    attitude_rad = np.zeros((2, FRAMES, 3))
    attitude_rad[:, 30:50, 0] = -0.7
    onsets = np.full((2, 8), -1.0)
    onsets[:, 0] = 28
    arrays = {
        "target_m": target_m,
        "target_rad": np.array([[0.0] * FRAMES, [0.5 * np.pi] * FRAMES]),
        "size_m": np.tile([4.6, 1.9, 1.5], (2, 1)),
        "attitude_rad": attitude_rad,
        "mount_rad": np.zeros((2, 1)),
        "start_m": np.tile([0.0, 0.0, 60.0], (2, 1)),
        "path_m": target_m.copy(),
        "yaw_rad": np.zeros((2, 1)),
        "onsets": onsets,
    }
    return EpisodeBank("road-town-v2", PRESET, np.array(SEEDS), arrays)


def model(**changes: Any) -> ErrorModel:
    """Return a model that tracks a plainly visible target with errors of 0.3 m, and else is lost with errors of 4 m."""
    knots, quantiles = len(KNOT_FRAMES), len(QUANTILE_Z)
    rates = np.zeros((3, len(CONDITION_FRAMES), 2, 3, 3))
    rates[0, ..., 0], rates[1:, ..., 1] = 1.0, 1.0
    error_m = np.zeros((2, 3, knots, quantiles))
    error_m[:, 0], error_m[:, 1], error_m[:, 2] = 0.3 * QUANTILE_Z, 4.0 * QUANTILE_Z, 10.0 + QUANTILE_Z
    probability = np.zeros((3, 2, quantiles))
    probability[0], probability[1], probability[2] = 0.95, 0.1, 0.8
    values: dict[str, Any] = {
        "tracker": "hand_made",
        "scenario": "road-town-v2",
        "made": {},
        "rates": rates,
        "kept": np.tile([[0.5], [0.9], [0.9]], (1, LATENTS)),
        "error_m": error_m,
        "spread_m": np.tile(np.exp(0.2 * QUANTILE_Z), (3, knots, 1)),
        "densest_share": np.ones((3, knots, quantiles)),
        "densest_offset": np.zeros((2, 3, quantiles)),
        "probability": probability,
        "length": np.ones((3, quantiles)),
        "known_share": np.ones((3, knots)),
        "looked_again": 0.0,
    }
    return ErrorModel(**values | changes)
