"""What a policy observes: the channels of an env, alone or several in a dictionary."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.envs.settings import FollowSettings
from scenarios.scenario import Scenario
from scenarios.truth import Truth
from trackers.belief.features import FEATURES
from trackers.types import Observation

ELSEWHERE, TARGET, OTHERS = 0, 1, 2
"""Labels of ``segmentation``: no object of the scene, the target; others of the scene's first class."""

FARTHEST_M = 10_000.0
"""Largest number in ``depth``, to which greater ones are clipped: spaces of observations are finite."""

Observed = NDArray[Any] | dict[str, NDArray[Any]]


class Channels:
    """The channels of an env's observations.

    Attributes:
        space: of an observation.
    """

    def __init__(self, settings: FollowSettings) -> None:
        self._scenario, self._alone = catalog.scenario(settings.scenario), settings.observes_one
        self._names = settings.channels
        height_px, width_px, _ = picture_size(settings)
        size, last = (height_px, width_px), OTHERS + len(_classes(self._scenario)) - 1
        known: dict[str, gym.Space[Any]] = {
            "track": gym.spaces.Box(-1.0, 1.0, (len(FEATURES),), np.float32),
            "pixels": gym.spaces.Box(0, 255, (*size, 3), np.uint8),
            "depth": gym.spaces.Box(0.0, FARTHEST_M, size, np.float32),
            "segmentation": gym.spaces.Box(0, last, size, np.uint8),
        }
        spaces = {name: known[name] for name in self._names}
        self.space = spaces[self._names[0]] if self._alone else gym.spaces.Dict(spaces)

    def observed(self, seen: Observation, truth: Truth, features: Callable[[], NDArray[np.float32]]) -> Observed:
        """Return an observation in arrays of its own.

        Args:
            seen: the picture that has arrived. truth: of the same instant. features: returns those of the belief.
        """
        known: dict[str, Callable[[], NDArray[Any]]] = {
            "track": features,
            "pixels": seen.image_rgb.copy,
            "depth": lambda: depth_of(truth),
            "segmentation": lambda: segmentation_of(self._scenario, truth),
        }
        if self._alone:
            return known[self._names[0]]()
        return {name: known[name]() for name in self._names}


def depth_of(truth: Truth) -> NDArray[np.float32]:
    """Return the depth (H, W) in metres along the optical axis, at most ``FARTHEST_M``; 0 where nothing is seen."""
    depth_m = np.minimum(truth.depth_m, np.float32(FARTHEST_M))
    depth_m[np.isinf(truth.depth_m)] = 0.0
    return depth_m


def segmentation_of(scenario: Scenario[Any], truth: Truth) -> NDArray[np.uint8]:
    """Return the label of each pixel (H, W): ``ELSEWHERE``, ``TARGET``, or ``OTHERS`` and the number of the class."""
    classes = _classes(scenario)
    # The sky's id, -1, is the last one.
    labels = np.full(max(int(truth.instance_map.max()), *truth.instance_id.tolist()) + 2, ELSEWHERE, np.uint8)
    labels[truth.instance_id] = [OTHERS + classes.index(scenario.classes[kind]) for kind in truth.kinds]
    labels[truth.instance_id[truth.index_of(scenario.target)]] = TARGET
    return labels[truth.instance_map]


def _classes(scenario: Scenario[Any]) -> list[str]:
    return list(dict.fromkeys(scenario.classes.values()))


def picture_size(settings: FollowSettings) -> tuple[int, int, int]:
    """Return (height, width, 3) of the pictures."""
    preset = settings.configuration({})
    return preset.height_px, preset.width_px, 3
