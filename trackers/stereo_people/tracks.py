"""Tracks of all visible people, and the joint assignment of sightings to them."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.light_adaptive_stereo.person_kalman import PersonKalman
from trackers.stereo_people.look import Look, LookModel, LookParameters

_GATE = 16.0
"""Greatest squared Mahalanobis distance of a place."""
_PART_NOISE = 3.0
"""Error of the middle of a part of a body over that of the whole."""
_TURNED_S = 0.5
_HEIGHT_OFF = -2.0
"""Lower bound of a height's log-likelihood ratio: a lintel or the sky above a head makes a person taller."""
_UNLIKE, _UNLIKE_FRAMES = -6.0, 6
"""A person who looks this different is half hidden, unless it lasts for so many frames."""
_UNLIKEST = -5.0
"""Lower bound of a look's log-likelihood ratio: light and occluders can change any look."""
_BESIDE_FRAMES, _CONTINUED = 8, 1.0
"""After so many frames beside the target a track is another person; log-likelihood ratio that it still is."""
_ROOM_M2 = 40.0
"""Area in which a new person may appear."""


@dataclass(frozen=True)
class TrackParameters:
    """Motion and measurement of people.

    Attributes:
        acceleration_mps2: standard deviation of the acceleration.
        place_noise_m, place_noise_per_m2: of a measured place: at the camera, and growing with the distance squared.
        height_noise_m: of a measured height.
        look_weight: weight of a look's log-likelihood, as its parts' errors are not independent.
        kept_s: time after which a track without a sighting is dropped.
        look: variation of looks.
    """

    acceleration_mps2: float = 1.5
    place_noise_m: float = 0.06
    place_noise_per_m2: float = 0.004
    height_noise_m: float = 0.07
    look_weight: float = 0.35
    kept_s: float = 2.0
    look: LookParameters = field(default_factory=LookParameters)


@dataclass(frozen=True)
class Sighting:
    """A person seen on one frame.

    Attributes:
        place_m: (2,) in the frame of odometry. distance_m: from the camera.
        height_m: NaN where the head is not visible. look: colours.
    """

    place_m: NDArray[np.float64]
    distance_m: float
    height_m: float
    look: Look


class Track:
    """One person over time.

    Attributes:
        filter: place and velocity. look: estimated look. height_m: mean of the measured heights.
        unseen_s: time since the last sighting. confirmed_s: time of the last sighting of the whole body. latest: that
            sighting. favour: log-likelihood ratio of being the target, to the present one, summed over frames.
    """

    def __init__(self, sighting: Sighting, time_s: float, parameters: TrackParameters) -> None:
        self._parameters = parameters
        self.filter = PersonKalman(sighting.place_m, parameters.acceleration_mps2, self._noise_m(sighting))
        self.look = LookModel(sighting.look, parameters.look)
        self.height_m, self._heights = sighting.height_m, int(np.isfinite(sighting.height_m))
        self.unseen_s, self.confirmed_s, self.latest, self.favour = 0.0, time_s, sighting, 0.0
        self._beside_frames = 0
        self._look_beside: LookModel | None = None
        self._unlike = 0

    def predict(self, seconds: float, shift: NDArray[np.float64], loosened: float) -> None:
        """Advance the track by one frame; ``shift`` and ``loosened`` as in ``LookModel.predict``."""
        self.filter.predict(seconds)
        self.look.predict(shift, loosened, is_lost=self.unseen_s > _TURNED_S)
        if self._look_beside is not None:
            self._look_beside.predict(shift, loosened, is_lost=False)
        self.unseen_s += seconds

    def correct(self, sighting: Sighting, time_s: float) -> None:
        """Update the track with a sighting of the whole body."""
        self._correct_place(sighting, self._noise_m(sighting))
        self.confirmed_s, self.latest = time_s, sighting
        self._unlike = self._unlike + 1 if self.look.likeness(sighting.look) < _UNLIKE else 0
        if self._unlike in range(1, _UNLIKE_FRAMES):
            return
        self.look.correct(sighting.look)
        if np.isfinite(sighting.height_m):
            self._heights += 1
            before_m = self.height_m if self._heights > 1 else sighting.height_m
            self.height_m = before_m + (sighting.height_m - before_m) / min(self._heights, 30)

    def correct_by_part(self, sighting: Sighting) -> None:
        """Update the place, not the look, with a sighting of a part of the body."""
        self._correct_place(sighting, _PART_NOISE * self._noise_m(sighting))

    def _correct_place(self, sighting: Sighting, noise_m: float) -> None:
        self.filter.correct(sighting.place_m, noise_m)
        self.unseen_s = 0.0

    def score(self, sighting: Sighting) -> float:
        """Return the log-likelihood ratio of a sighting: of this person to a new one; -inf outside the gate."""
        covariance = self.filter.innovation(self._noise_m(sighting))
        away_m = sighting.place_m - self.filter.place_m
        squared = float(away_m @ np.linalg.solve(covariance, away_m))
        if squared > _GATE:
            return -np.inf
        place = -0.5 * squared - 0.5 * np.log(np.linalg.det(2 * np.pi * covariance)) + np.log(_ROOM_M2)
        return float(place) + self.appearance(sighting)

    def continue_lost(self, lost: Track) -> None:
        """Continue a lost track: take over its look and height."""
        self.look, self.height_m, self._heights = copy(lost.look), lost.height_m, lost._heights

    def count_beside(self) -> None:
        """Count a frame on which this person and the target are visible together; keep the look of such a frame."""
        self._beside_frames += 1
        if self._beside_frames >= _BESIDE_FRAMES:
            self._look_beside = copy(self.look)

    def other_evidence(self) -> float:
        """Return the log-likelihood ratio of still being the person seen beside the target; 0 if there was none."""
        if self._look_beside is None:
            return 0.0
        return max(self.appearance(self.latest, self._look_beside), 0.0) + _CONTINUED

    def appearance(self, sighting: Sighting, look: LookModel | None = None) -> float:
        """Return the log-likelihood ratio of a sighting's look and height; ``look`` replaces the track's own."""
        p = self._parameters
        total = max(p.look_weight * (look or self.look).likeness(sighting.look), _UNLIKEST)
        if np.isfinite(sighting.height_m) and np.isfinite(self.height_m):
            off = (sighting.height_m - self.height_m) / (1.4 * p.height_noise_m)
            # Heights of the population vary by some 0.1 m.
            total += max(-0.5 * off**2 + 0.4, _HEIGHT_OFF)
        return total

    def _noise_m(self, sighting: Sighting) -> float:
        p = self._parameters
        return p.place_noise_m + p.place_noise_per_m2 * sighting.distance_m**2


def associate(tracks: Sequence[Track], sightings: Sequence[Sighting]) -> list[int | None]:
    """Return the index of each track's sighting, None for none: the greatest sum of scores, each of them above zero."""
    if not tracks or not sightings:
        return [None] * len(tracks)
    scores = np.array([[track.score(sighting) for sighting in sightings] for track in tracks])
    gains = np.maximum(np.nan_to_num(scores, neginf=-1.0), 0.0)
    found: list[int | None] = [None] * len(tracks)
    for row, column in zip(*linear_sum_assignment(-gains), strict=True):
        if scores[row, column] > 0.0:
            found[row] = int(column)
    return found
