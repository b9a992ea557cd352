"""Our gap method: regressions of where swimmers go, shipped with weights and learnt anew from the tracks at hand."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.gaps.types import Bridge, Piece, Surroundings
from trackers.swimmer.extrapolation import KNOTS, samples_ahead, way_ahead
from trackers.swimmer.features import Pasts
from trackers.swimmer.interpolation import GAPS, SHARES, Ends, samples_between, way_between
from trackers.swimmer.regression import Regression, Samples, fitted
from trackers.swimmer.windows import Recording, whole_past

PRIOR_FILE = "prior.json"
_RADIUS_SIGMAS = float(np.sqrt(-2.0 * np.log(0.05)))
"""Radius of the circle that holds 95 % of a round Gaussian, in standard deviations."""


class SwimGaps:
    """A ``GapMethod`` for targets that swim in a tank.

    Extrapolation and interpolation are regressions on the motion at the ends, the walls and the place where targets
    have been of late. They are shipped with weights from simulated swims and are learnt anew, with those as prior, by
    ``learn``. Time is counted in frames: the weights that are shipped suit about 30 frames per second.
    """

    def __init__(self) -> None:
        self.learn(())

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn from all pieces; what was learnt before is forgotten."""
        recording = Recording(pieces)
        self._home_px = recording.home_px
        self._ahead, self._between = dict(shipped()[0]), dict(shipped()[1])
        for ahead in KNOTS:
            self._ahead[ahead] = _learnt(samples_ahead(recording, ahead), self._ahead[ahead])
        for gap in GAPS:
            for share in SHARES:
                self._between[gap, share] = _learnt(samples_between(recording, gap, share), self._between[gap, share])

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        x, pause = whole_past(past)
        places, radii = way_ahead(self._ahead, self._pasts(x, around), pause + count)
        return _bridge(places[pause:], radii[pause:])

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        x, pause = whole_past(past)
        back = Piece(0, future.position_px[::-1], future.interval_s)
        y, later = whole_past(back)
        count = future.first_frame - past.end_frame
        places, radii = way_between(
            self._between, Ends(self._pasts(x, around), self._pasts(y, around)), pause + count + later
        )
        return _bridge(places[pause : pause + count], radii[pause : pause + count])

    def _pasts(self, x: NDArray[np.float64], around: Surroundings) -> Pasts:
        bounds = around.bounds_xyxy
        if bounds is None:
            bounds = np.concatenate([x.min(axis=0), x.max(axis=0)])
        home = 0.5 * (bounds[:2] + bounds[2:]) if self._home_px is None else self._home_px
        return Pasts(x[None], bounds[None], home[None])


def _learnt(samples: Samples, prior: Regression) -> Regression:
    return fitted(samples, prior) if len(samples.step) else prior


def _bridge(places: NDArray[np.float64], radii: NDArray[np.float64]) -> Bridge:
    sigma = np.maximum(radii / _RADIUS_SIGMAS, 0.1)
    return Bridge(places, sigma[:, None, None] ** 2 * np.eye(2))


@cache
def shipped() -> tuple[dict[int, Regression], dict[tuple[int, float], Regression]]:
    """Return the shipped regressions, by frames ahead, and by length of the gap and share of it."""
    content: Mapping[str, Any] = json.loads(resources.files("trackers.swimmer").joinpath(PRIOR_FILE).read_text())
    ahead = {each["ahead"]: _read(each) for each in content["ahead"]}
    return ahead, {(each["gap"], each["share"]): _read(each) for each in content["between"]}


def _read(content: Mapping[str, Any]) -> Regression:
    return Regression(np.array(content["weights"]), np.array(content["spread"]))
