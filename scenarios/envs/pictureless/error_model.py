"""What a tracker gets wrong, fitted to logged runs of the rendered env: it stands for picture and tracker.

A tracker is in one of three modes on every frame: *tracking* (it says that it sees its target, and it is there),
*lost* (it does not say so), *wrong* (it says so, and the target is elsewhere). Which mode follows is drawn by rates
that depend on what is so: the condition (the target plain to see, cut or half hidden, or unseen), for how long that
has been so, and whether it was tracked a moment ago. What the tracker answers is drawn from the distributions logged
in each mode: every random thing is a latent first-order autoregression of unit variance, mapped through logged
quantiles.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.pictureless.bank import pictureless_of
from scenarios.envs.pictureless.life import LATENTS
from sim.checks import check

TRACKING, LOST, WRONG = range(3)
PLAIN, CUT, UNSEEN = range(3)
PLAIN_SHARE, UNSEEN_SHARE = 0.6, 0.1
"""Shares of the target that is seen: from the first on it is plain to see, below the second unseen."""
CONDITION_FRAMES = (0, 2, 5, 15, 45)
"""Since the condition began: from how many frames on each row of rates holds."""
LONG_LOST_FRAMES = 15
KNOT_FRAMES = (1.0, 4.0, 10.0, 22.0, 45.0, 90.0)
"""Since the tracker was last tracking: where distributions are held; between them they are interpolated. Of the mode
``tracking`` the first three are those of the conditions instead."""
QUANTILE_Z = np.linspace(-2.4, 2.4, 17)
"""Quantiles are held at these places of the standard normal distribution."""


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """One tracker in one env; modes M = 3, conditions C = 3, knots K = 6, quantiles Q = 17.

    Attributes:
        tracker, scenario: whose answers these are, and where.
        made: how it was made: seeds, controllers, frames, date.
        rates: (C, 5, 2, M, M) chance of each mode (last axis) after each mode, by condition, how long that has been
            so, and whether it is longer than ``LONG_LOST_FRAMES`` since the tracker was tracking.
        kept: (M, 8) what is left of each latent number from frame to frame.
        error_m: (2, M, K, Q) of the place, along and across the axis: the target's heading, or the line of sight of a
            camera that looks ahead, as it was when last tracked.
        spread_m, densest_share: (M, K, Q). densest_offset: (2, M, Q) over the spread.
        probability: (M, 2, Q) of being in view, of an estimate outside the picture and in it.
        length: (M, Q) the box's length over that of the target if it were there.
        known_share: (M, K) of frames on which the tracker says where.
        looked_again: chance on each frame that a lost tracker whose estimate lies in the picture moves it elsewhere.
    """

    tracker: str
    scenario: str
    made: Mapping[str, Any]
    rates: NDArray[np.float64]
    kept: NDArray[np.float64]
    error_m: NDArray[np.float64]
    spread_m: NDArray[np.float64]
    densest_share: NDArray[np.float64]
    densest_offset: NDArray[np.float64]
    probability: NDArray[np.float64]
    length: NDArray[np.float64]
    known_share: NDArray[np.float64]
    looked_again: float

    def __post_init__(self) -> None:
        knots, quantiles = len(KNOT_FRAMES), len(QUANTILE_Z)
        shapes = {
            "rates": (3, len(CONDITION_FRAMES), 2, 3, 3),
            "kept": (3, LATENTS),
            "error_m": (2, 3, knots, quantiles),
            "spread_m": (3, knots, quantiles),
            "densest_share": (3, knots, quantiles),
            "densest_offset": (2, 3, quantiles),
            "probability": (3, 2, quantiles),
            "length": (3, quantiles),
            "known_share": (3, knots),
        }
        for name, shape in shapes.items():
            got = getattr(self, name)
            check(name, got.shape == shape and bool(np.isfinite(got).all()), f"finite numbers {shape}", got.shape)

    def to_json(self) -> str:
        """Return it as text, numbers to five digits."""
        values = {
            name: _rounded(value.tolist()) if isinstance(value, np.ndarray) else value
            for name, value in ((field.name, getattr(self, field.name)) for field in dataclasses.fields(self))
        }
        rows = ",\n".join(f" {json.dumps(name)}: {json.dumps(value)}" for name, value in values.items())
        return f"{{\n{rows}\n}}\n"


def model_from_json(text: str) -> ErrorModel:
    """Return a model as ``to_json`` wrote it."""
    values = json.loads(text)
    arrays: dict[str, Any] = {
        name: np.array(value, dtype=float) if isinstance(value, list) else value for name, value in values.items()
    }
    return ErrorModel(**arrays)


def model_path(scenario: str, tracker: str) -> Path:
    """Return the file of a tracker's model: it lies beside the module of the scenario's ``Pictureless``."""
    return Path(inspect.getfile(type(pictureless_of(scenario)))).with_name(f"{tracker}.json")


def error_model(scenario: str, tracker: str) -> ErrorModel:
    """Return the model that comes with a scenario. Raises ValueError for a tracker without one."""
    path = model_path(scenario, tracker)
    known = ", ".join(sorted(each.stem for each in path.parent.glob("*.json")))
    check("tracker", path.is_file(), f"one with an error model: {known}", repr(tracker))
    return model_from_json(path.read_text())


def _rounded(value: Any) -> Any:
    return [_rounded(each) for each in value] if isinstance(value, list) else float(f"{value:.5g}")
