"""Policies that were never trained."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackers.belief.features import FEATURES
from trackers.controllers.policy import Policy
from trackers.types import Carrier


def made_up_policy(
    carrier: Carrier,
    weights: Sequence[NDArray[np.float32]],
    biases: Sequence[NDArray[np.float32]],
    history: int = 0,
    action_repeat: int = 1,
    cells: Sequence[NDArray[np.float32]] = (),
) -> Policy:
    """Return a policy that steers alone by a network of these numbers, said to be trained in the town with ``hold``."""
    width = (1 + history) * len(FEATURES)
    return Policy(
        env="frameout/RoadTownFollow-v3",
        carrier=carrier,
        tracker="hold",
        base=None,
        correction_share=0.5,
        corrects="always",
        features=FEATURES,
        history=history,
        action_repeat=action_repeat,
        hidden="tanh",
        output="clip",
        mean=np.zeros(width, np.float32),
        deviation=np.ones(width, np.float32),
        weights=tuple(weights),
        biases=tuple(biases),
        cells=tuple(cells),
    )


def random_policy(carrier: Carrier, history: int = 0, action_repeat: int = 1, cells: int = 0) -> Policy:
    """Return a policy whose network, with ``cells`` of an LSTM, says anything."""
    rng = np.random.Generator(np.random.PCG64(0))
    width = (1 + history) * len(FEATURES)
    sizes = (cells or width, 8, len(carrier.axes))
    weights = [rng.normal(size=(b, a)).astype(np.float32) for a, b in itertools.pairwise(sizes)]
    biases = [rng.normal(size=b).astype(np.float32) for b in sizes[1:]]
    shapes = [(4 * cells, width), (4 * cells, cells), (4 * cells,)] if cells else []
    lstm = [rng.normal(size=shape).astype(np.float32) for shape in shapes]
    return made_up_policy(carrier, weights, biases, history, action_repeat, lstm)
