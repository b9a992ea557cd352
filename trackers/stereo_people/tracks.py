"""Everybody who is seen, followed at once: who is explained by somebody else is not the target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.paper_b.person_kalman import PersonKalman
from trackers.stereo_people.look import Look, LookModel, LookParameters

_GATE = 16.0
"""Greatest squared Mahalanobis distance of a place."""
_PART_NOISE = 3.0
"""The middle of a part is so much further off than that of the whole, in standard deviations."""
_TURNED_S = 0.5
_HEIGHT_OFF = -2.0
"""A lintel or the sky above a head can make anybody taller: a height counts against him by no more."""
_UNLIKE, _UNLIKE_FRAMES = -6.0, 6
"""Who looks so unlike himself is half hidden by somebody; only if it lasts he has changed."""
_UNLIKEST = -5.0
"""Light and half-hidden bodies can make anybody look unlike himself: a look counts against him by no more."""
_BESIDE_FRAMES, _CONTINUED = 8, 1.0
"""Who was seen beside the target on so many frames is somebody else, and likelier to be so still than not."""
_ROOM_M2 = 40.0
"""Somebody new may be anywhere in so much room."""


@dataclass(frozen=True)
class TrackParameters:
    """How people move and are seen.

    Attributes:
        acceleration_mps2: standard deviation of the acceleration.
        place_noise_m, place_noise_per_m2: of a measured place: at the camera, and growing with the distance squared.
        height_noise_m: of a measured height.
        look_weight: how much a look's log-likelihood counts; its parts' errors are not independent.
        kept_s: how long somebody is expected who is not seen.
        look: how people look.
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
    """Somebody seen on one frame.

    Attributes:
        place_m: (2,) in the frame of odometry. distance_m: from the camera.
        height_m: NaN where the top is not seen. look: colours.
    """

    place_m: NDArray[np.float64]
    distance_m: float
    height_m: float
    look: Look


class Track:
    """One person over time.

    Attributes:
        filter: place and velocity. look: what is known of his look. height_m: mean of what was measured.
        unseen_s: since he was seen last. confirmed_s: time he was seen whole last. latest: that sighting.
        favour: what speaks for his being the target rather than who is believed to be he, summed over frames.
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
        """Go on by a frame."""
        self.filter.predict(seconds)
        self.look.predict(shift, loosened, is_lost=self.unseen_s > _TURNED_S)
        if self._look_beside is not None:
            self._look_beside.predict(shift, loosened, is_lost=False)
        self.unseen_s += seconds

    def correct(self, sighting: Sighting, time_s: float) -> None:
        """Take in a sighting of the whole person."""
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
        """Take in a sighting of a part of him: it says about where he is, not how he looks."""
        self._correct_place(sighting, _PART_NOISE * self._noise_m(sighting))

    def _correct_place(self, sighting: Sighting, noise_m: float) -> None:
        self.filter.correct(sighting.place_m, noise_m)
        self.unseen_s = 0.0

    def score(self, sighting: Sighting) -> float:
        """Return the log-likelihood ratio of a sighting: of this person to somebody new; -inf too far off."""
        covariance = self.filter.innovation(self._noise_m(sighting))
        away_m = sighting.place_m - self.filter.place_m
        squared = float(away_m @ np.linalg.solve(covariance, away_m))
        if squared > _GATE:
            return -np.inf
        place = -0.5 * squared - 0.5 * np.log(np.linalg.det(2 * np.pi * covariance)) + np.log(_ROOM_M2)
        return float(place) + self.appearance(sighting)

    def take_for(self, lost: Track) -> None:
        """Hold him for somebody who was lost: what is known of that one's look and height is his now."""
        self.look, self.height_m, self._heights = lost.look.copy(), lost.height_m, lost._heights

    def count_beside(self) -> None:
        """Take note that he was seen at the same time as the target: how he looks now is how somebody else looks."""
        self._beside_frames += 1
        if self._beside_frames >= _BESIDE_FRAMES:
            self._look_beside = self.look.copy()

    def still_himself(self) -> float:
        """Return what speaks for his being still who was seen beside the target: 0 if nobody was, or hardly."""
        if self._look_beside is None:
            return 0.0
        return max(self._appearance(self.latest, self._look_beside), 0.0) + _CONTINUED

    def appearance(self, sighting: Sighting) -> float:
        """Return what look and height say of its being this person, a log-likelihood ratio."""
        return self._appearance(sighting, self.look)

    def _appearance(self, sighting: Sighting, look: LookModel) -> float:
        p = self._parameters
        total = max(p.look_weight * look.likeness(sighting.look), _UNLIKEST)
        if np.isfinite(sighting.height_m) and np.isfinite(self.height_m):
            off = (sighting.height_m - self.height_m) / (1.4 * p.height_noise_m)
            # Anybody's height varies by some 0.1 m.
            total += max(-0.5 * off**2 + 0.4, _HEIGHT_OFF)
        return total

    def _noise_m(self, sighting: Sighting) -> float:
        p = self._parameters
        return p.place_noise_m + p.place_noise_per_m2 * sighting.distance_m**2


def associate(tracks: Sequence[Track], sightings: Sequence[Sighting]) -> list[int | None]:
    """Return which sighting is each track's, None where none is: the greatest sum of scores, none of them negative."""
    if not tracks or not sightings:
        return [None] * len(tracks)
    scores = np.array([[track.score(sighting) for sighting in sightings] for track in tracks])
    gains = np.maximum(np.nan_to_num(scores, neginf=-1.0), 0.0)
    found: list[int | None] = [None] * len(tracks)
    for row, column in zip(*linear_sum_assignment(-gains), strict=True):
        if scores[row, column] > 0.0:
            found[row] = int(column)
    return found
