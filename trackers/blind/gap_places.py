"""Blind gap methods: places that do not depend on how a target moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackers.gaps import Bridge, Pictureless, Piece, Surroundings, last_state
from trackers.registry import NoParameters, register

_HEADING_FRAMES = 5


class _Place(Pictureless):
    """A gap method that predicts one place on all lost frames."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        pass

    @property
    def gap_method(self) -> _Place:
        """The method itself."""
        return self

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return Bridge(np.tile(self.place_px(past, _bounds_of(past, around)), (count, 1)))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return None

    def place_px(self, past: Piece, bounds_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the place (2,)."""
        raise NotImplementedError


@register("fish_mean_place", role="blind", summary="the mean place of the track so far", suites=("fish",))
class MeanPlace(_Place):
    """The mean of the measured positions."""

    def place_px(self, past: Piece, bounds_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
        """See ``_Place``."""
        return np.nanmean(past.position_px, axis=0)


@register("fish_middle", role="blind", summary="the middle of the region that targets reach", suites=("fish",))
class Middle(_Place):
    """The middle of the bounds."""

    def place_px(self, past: Piece, bounds_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
        """See ``_Place``."""
        return 0.5 * (bounds_xyxy[:2] + bounds_xyxy[2:])


@register("fish_wall_ahead", role="blind", summary="the wall in the direction of the exit", suites=("fish",))
class WallAhead(_Place):
    """The point where the ray along the velocity at the exit meets the bounds."""

    def place_px(self, past: Piece, bounds_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
        """See ``_Place``."""
        last_px, velocity, _ = last_state(past, _HEADING_FRAMES)
        inside = np.clip(last_px, bounds_xyxy[:2], bounds_xyxy[2:])
        wall = np.where(velocity > 0, bounds_xyxy[2:], bounds_xyxy[:2])
        moves = np.abs(velocity) > 1e-9
        if not moves.any():
            return inside
        return inside + velocity * ((wall - inside)[moves] / velocity[moves]).min()


def _bounds_of(past: Piece, around: Surroundings) -> NDArray[np.float64]:
    if around.bounds_xyxy is not None:
        return around.bounds_xyxy
    return np.concatenate([np.nanmin(past.position_px, axis=0), np.nanmax(past.position_px, axis=0)])
