"""Our gap method: regressions of where swimmers go, shipped with weights and learnt anew from the tracks at hand."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.gaps.types import Bridge, Piece, Surroundings
from trackers.swimmer.extrapolation import samples_ahead, way_ahead
from trackers.swimmer.features import Pasts
from trackers.swimmer.interpolation import Ends, samples_between, way_between
from trackers.swimmer.regression import Regression, Samples, fitted
from trackers.swimmer.windows import Recording, jitter_px, postures_of, whole_past

_LEAST_NOISE_PX = 0.1
_UNKNOWN = np.zeros(3)
PRIOR_FILE = "prior.json"
_RADIUS_SIGMAS = float(np.sqrt(-2.0 * np.log(0.05)))
"""Radius of the circle that holds 95 % of a round Gaussian, in standard deviations."""


class SwimGaps:
    """A ``GapMethod`` for targets that swim in a tank.

    Extrapolation and interpolation are regressions on the motion at the ends, the walls and the place where targets
    have been of late. They are shipped with weights from simulated swims and are learnt anew, with those as prior, by
    ``learn``. Time is counted in frames: the weights that are shipped suit about 30 frames per second.
    """

    def __init__(self, posture: bool = True, learns: bool = True) -> None:
        """Start with the shipped weights.

        Args:
            posture: whether headings and centre lines are used where they are given.
            learns: if False, ``learn`` is without effect.
        """
        self._posture, self._learns = posture, learns
        self.learn(())

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn from all pieces; what was learnt before is forgotten."""
        self._recording = Recording([self._allowed(piece) for piece in pieces] if self._learns else [])
        # Fitted when they are first asked for: most users need few of them.
        self._ahead = cache(lambda ahead: _learnt(samples_ahead(self._recording, ahead), shipped()[0][ahead]))
        self._between = cache(
            lambda gap, share: _learnt(samples_between(self._recording, gap, share), shipped()[1][gap, share])
        )

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        x, pause = whole_past(past)
        posture = postures_of(self._allowed(past))[len(past.position_px) - 1 - pause]
        noise_px = max(jitter_px(x), _LEAST_NOISE_PX)
        places, radii = way_ahead(self._ahead, self._pasts(x, around, posture), pause + count, noise_px)
        return _bridge(places[pause:], radii[pause:], noise_px)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        x, pause = whole_past(past)
        back = Piece(0, future.position_px[::-1], future.interval_s)
        y, later = whole_past(back)
        count = future.first_frame - past.end_frame
        ends = Ends(self._pasts(x, around, _UNKNOWN), self._pasts(y, around, _UNKNOWN))
        places, radii = way_between(self._between, ends, pause + count + later)
        return _bridge(places[pause : pause + count], radii[pause : pause + count], max(jitter_px(x), _LEAST_NOISE_PX))

    def _allowed(self, piece: Piece) -> Piece:
        return piece if self._posture else replace(piece, heading_rad=None, centre_line_px=None)

    def _pasts(self, x: NDArray[np.float64], around: Surroundings, posture: NDArray[np.float64]) -> Pasts:
        bounds = around.bounds_xyxy
        if bounds is None:
            bounds = np.concatenate([x.min(axis=0), x.max(axis=0)])
        home = 0.5 * (bounds[:2] + bounds[2:]) if self._recording.home_px is None else self._recording.home_px
        return Pasts(x[None], bounds[None], home[None], posture[None])


def _learnt(samples: Samples, prior: Regression) -> Regression:
    return fitted(samples, prior) if len(samples.step) else prior


def _bridge(places: NDArray[np.float64], radii: NDArray[np.float64], noise_px: float) -> Bridge:
    variance = (radii / _RADIUS_SIGMAS) ** 2 + noise_px**2
    return Bridge(places, variance[:, None, None] * np.eye(2))


@cache
def shipped() -> tuple[dict[int, Regression], dict[tuple[int, float], Regression]]:
    """Return the shipped regressions, by frames ahead, and by length of the gap and share of it."""
    content: Mapping[str, Any] = json.loads(resources.files("trackers.swimmer").joinpath(PRIOR_FILE).read_text())
    ahead = {each["ahead"]: _read(each) for each in content["ahead"]}
    return ahead, {(each["gap"], each["share"]): _read(each) for each in content["between"]}


def _read(content: Mapping[str, Any]) -> Regression:
    return Regression(np.array(content["weights"]), np.array(content["spread"]))
