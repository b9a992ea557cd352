"""Error models of trackers, fitted to logged runs of the rendered env; they replace picture and tracker.

On every frame a tracker is in one of three modes: *tracking* (it reports its target in view, and is right), *lost* (it
reports it out of view), *wrong* (it reports it in view, and the target is elsewhere). The next mode is drawn with rates
that depend on the target's condition (plainly visible, cut or half hidden, or unseen), on the condition's duration, and
on whether the target was tracked recently. The answers have the distributions logged in each mode: every random
quantity is a latent first-order autoregression of unit variance, mapped through logged quantiles.
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

from scenarios import catalog
from scenarios.envs.pictureless.bank import pictureless_of
from scenarios.envs.pictureless.episode_state import LATENTS
from sim.checks import check

TRACKING, LOST, WRONG = range(3)
PLAIN, CUT, UNSEEN = range(3)
PLAIN_SHARE, UNSEEN_SHARE = 0.6, 0.1
"""Visible shares of the target: from the first on it is plainly visible, below the second it is unseen."""
CONDITION_FRAMES = (0, 2, 5, 15, 45)
"""Each row of rates holds from this many frames after the condition began."""
LONG_LOST_FRAMES = 15
KNOT_FRAMES = (1.0, 4.0, 10.0, 22.0, 45.0, 90.0)
"""Frames since the tracker was last tracking at which distributions are stored, with interpolation between them. In the
mode ``tracking`` the first three knots stand for the conditions instead."""
QUANTILE_Z = np.linspace(-2.4, 2.4, 17)
"""Deviates of the standard normal distribution at which quantiles are stored."""
SHAPES: dict[str, tuple[int, ...]] = {
    "rates": (3, len(CONDITION_FRAMES), 2, 3, 3),
    "kept": (3, LATENTS),
    "error_m": (2, 3, len(KNOT_FRAMES), len(QUANTILE_Z)),
    "spread_m": (3, len(KNOT_FRAMES), len(QUANTILE_Z)),
    "densest_share": (3, len(KNOT_FRAMES), len(QUANTILE_Z)),
    "densest_offset": (2, 3, len(QUANTILE_Z)),
    "probability": (3, 2, len(QUANTILE_Z)),
    "length": (3, len(QUANTILE_Z)),
    "known_share": (3, len(KNOT_FRAMES)),
}
"""Shapes of a model's arrays."""


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """One tracker in one env; modes M = 3, conditions C = 3, knots K = 6, quantiles Q = 17.

    Attributes:
        tracker, scenario: names of the modelled tracker and of its scenario.
        made: its origin: seeds, controllers, frames, date.
        rates: (C, 5, 2, M, M) probability of each mode (last axis) after each mode, by condition, by the condition's
            duration, and by whether the tracker was last tracking more than ``LONG_LOST_FRAMES`` ago.
        kept: (M, 8) coefficient of each latent autoregression.
        error_m: (2, M, K, Q) of the place, along and across the axis: the target's heading, or for a camera that looks
            ahead the line of sight, both as when last tracked; for one that looks around right and down in the picture,
            at the target's depth.
        spread_m, densest_share: (M, K, Q). densest_offset: (2, M, Q) over the spread.
        probability: (M, 2, Q) of being in view, for an estimate outside the picture and inside it.
        length: (M, Q) the box's length over the length of the target at the estimated place.
        known_share: (M, K) share of frames with an estimate.
        looked_again: probability per frame that a lost tracker with an estimate in the picture moves it elsewhere.
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
        for name, shape in SHAPES.items():
            got = getattr(self, name)
            check(name, got.shape == shape and bool(np.isfinite(got).all()), f"finite numbers {shape}", got.shape)

    def to_json(self) -> str:
        """Return the model as text, numbers to five digits."""
        values = {
            name: _rounded(value.tolist()) if isinstance(value, np.ndarray) else value
            for name, value in ((field.name, getattr(self, field.name)) for field in dataclasses.fields(self))
        }
        rows = ",\n".join(f" {json.dumps(name)}: {json.dumps(value)}" for name, value in values.items())
        return f"{{\n{rows}\n}}\n"


def model_from_json(text: str) -> ErrorModel:
    """Return a model from the text of ``to_json``."""
    values = json.loads(text)
    arrays: dict[str, Any] = {
        name: np.array(value, dtype=float) if isinstance(value, list) else value for name, value in values.items()
    }
    return ErrorModel(**arrays)


def model_path(scenario: str, tracker: str) -> Path:
    """Return the file of a tracker's model, which lies beside the module of the scenario's ``Pictureless``."""
    version = catalog.scenario(scenario).id
    return Path(inspect.getfile(type(pictureless_of(scenario)))).with_name(f"{version}-{tracker}.json")


def error_model(scenario: str, tracker: str) -> ErrorModel:
    """Return a tracker's model from its scenario's package. Raises ValueError if there is none."""
    path = model_path(scenario, tracker)
    among = model_path(scenario, "*")
    known = ", ".join(sorted(each.stem.removeprefix(among.stem[:-1]) for each in path.parent.glob(among.name)))
    wanted = f"one with a model of its errors in {scenario} ({known or 'none'}), or pictures"
    check("tracker", path.is_file(), wanted, f"{tracker!r}; frameout train --fit-model makes a model")
    return model_from_json(path.read_text())


def _rounded(value: Any) -> Any:
    return [_rounded(each) for each in value] if isinstance(value, list) else float(f"{value:.5g}")
