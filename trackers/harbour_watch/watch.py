"""The watch over one learnt site, picture by picture.

Sun and rain do not reach the ground below a car: once it has driven off, that differs from all that was known of the
place, and would be found as one more object that stands there. A car that stood there since before the start leaves a
place behind that differs from the background because the background shows the car.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.mark import Mark
from trackers.harbour_watch.sightings import BIRD, CAR, Sighting, place_regions
from trackers.harbour_watch.site_model import SiteModel
from trackers.harbour_watch.tracks import Rates, Tracks
from trackers.site import Picture, SiteView
from trackers.types import Estimate, Track

_RATE = 0.3
"""By which the appearance of what stands is followed: it cools, and clouds pass."""
_CHANGED, _CHANGED_SHARE = 6.0, 0.6
"""Deviations of the noise by which a pixel shows something else, and the share of a place from which it is left."""
_LEAVES = 6
"""Pictures until it has surely driven off."""
_RIM_PX = (-4, -4, 4, 4)
"""Added to a place: the shade about the car."""
_MORE_EDGES = 1.4
"""Factor by which the background must have more edges: a car that stood there before it was found has as many."""
_OUTLINE_PX = (-2, -2, 2, 2)
"""Added to a region, so that its outline lies inside."""


@dataclass(eq=False)
class _Place:
    """``box`` (4,) whole pixels, ``seen`` what they show beyond the low-rank background, counts.

    ``leaves``: pictures until its car has surely driven off; None while it stands.
    """

    box: tuple[int, int, int, int]
    seen: Picture
    leaves: int | None = None


class Parked:
    """The places of parked cars."""

    def __init__(self) -> None:
        """Begin with none."""
        self._places: dict[int, _Place] = {}

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(self._places)

    def look(self, parked: Iterable[Mark], left: Picture) -> None:
        """Take in how parked cars look on a picture less its low-rank background (H, W)."""
        for mark in parked:
            box = _within(mark.seen_px, left.shape)
            x0, y0, x1, y1 = box
            if mark.identity not in self._places:
                self._places[mark.identity] = _Place(box, left[y0:y1, x0:x1].copy())
        for place in self._places.values():
            x0, y0, x1, y1 = place.box
            place.seen += _RATE * (left[y0:y1, x0:x1] - place.seen)

    def left(self, left: Picture, noise: Picture) -> Iterator[tuple[int, int, int, int]]:
        """Yield the boxes with a rim, in pixels, of places that show something else, until their cars are gone.

        Args:
            left: (H, W) counts beyond the low-rank background. noise: (H, W) its standard deviation.
        """
        for identity, place in list(self._places.items()):
            x0, y0, x1, y1 = place.box
            changed = np.abs(left[y0:y1, x0:x1] - place.seen) > _CHANGED * noise[y0:y1, x0:x1]
            if place.leaves is None and changed.mean() > _CHANGED_SHARE:
                place.leaves = _LEAVES
            if place.leaves is not None:
                yield with_rim(place.box, left.shape)
                place.leaves -= 1
                if place.leaves == 0:
                    del self._places[identity]


def shows_background_behind(picture: Picture, background: Picture, noise: Picture, box_xyxy: NDArray) -> bool:
    """Return whether something has left a place, rather than come: the background has more edges there.

    ``E = mean (d/dx)^2 + mean (d/dy)^2`` over the place, by central differences, of which noise makes ``4 noise^2``.

    Args:
        picture, background: (H, W) counts. noise: (H, W) standard deviation of the picture.
        box_xyxy: (4,) place, pixels.
    """
    x0, y0, x1, y1 = _within(np.add(box_xyxy, _OUTLINE_PX), picture.shape)
    now, before = picture[y0:y1, x0:x1], background[y0:y1, x0:x1]
    return _edges(before) > _MORE_EDGES * max(_edges(now) - 4.0 * float((noise[y0:y1, x0:x1] ** 2).mean()), 0.0)


def _edges(part: Picture) -> float:
    along, down = part[:, 2:] - part[:, :-2], part[2:] - part[:-2]
    return float((along**2).mean() + (down**2).mean()) if along.size and down.size else 0.0


def with_rim(box_xyxy: NDArray | tuple[int, ...], shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return a place with the shade about it, in whole pixels inside a picture of ``shape``."""
    return _within(np.add(box_xyxy, _RIM_PX), shape)


def _within(box_xyxy: NDArray, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return a box in whole pixels inside a picture of ``shape``, at least one pixel large."""
    x0, y0 = np.clip(np.floor(box_xyxy[:2]), 0, np.subtract(shape[::-1], 1)).astype(int).tolist()
    x1, y1 = np.clip(np.ceil(box_xyxy[2:]), [x0 + 1, y0 + 1], shape[::-1]).astype(int).tolist()
    return x0, y0, x1, y1


_LEVEL_EVERY = 15
_USUAL_STEP_S, _LONGEST_STEP_S = 2.0, 30.0
_BOX_RIM_PX = (-2, -2, 3, 3)


class Watch:
    """Regions, tracks and what the background has lately shown.

    Attributes:
        shape: of its pictures.
        sightings: of the last picture. tracks: of all objects. level_m: height of the water.
    """

    def __init__(self, model: SiteModel, view: SiteView, *, claims: float, clip: float, noise_frames: float) -> None:
        """Begin; the parameters are those of ``harbour_watch``."""
        self.shape = model.shape
        self._model, self._view = model, view
        self._claims, self._clip, self._noise_rate = claims, clip, 1.0 / noise_frames
        self.tracks = Tracks(view, Rates())
        self.sightings: list[Sighting] = []
        self.level_m = model.water_level.mean_m
        self._coefficients: NDArray[np.float64] | None = None
        self._time_s: float | None = None
        self._frame = 0
        self._parked, self._numbers = Parked(), np.arange(np.prod(self.shape)).reshape(self.shape)

    def update(self, picture: Picture, time_s: float) -> None:
        """Take in a picture (H, W)."""
        model = self._model
        dt_s = _USUAL_STEP_S if self._time_s is None else min(max(time_s - self._time_s, 0.0), _LONGEST_STEP_S)
        self._time_s = time_s
        if self._frame % _LEVEL_EVERY == 0:
            level_m = model.water_level.of(picture)
            self.level_m = self.level_m if level_m is None else level_m
        flat = picture.ravel()
        self._coefficients = model.low_rank.coefficients(flat, self._coefficients)
        left = flat - model.low_rank.explained(self._coefficients)
        deviation = model.memory.deviation(left).reshape(picture.shape)
        filters = model.detector.filters
        doubtful = model.memory.doubtful().reshape(picture.shape)
        scaled = filters.scaled(filters.filtered(deviation, self._clip), doubtful)
        known = self.tracks.predicted(dt_s, self.level_m)
        regions = model.detector.regions(scaled, deviation, model.watched, known)
        self.sightings = place_regions(regions, self._view, model.water, self.level_m)
        ratios = np.array([model.clutter.log_ratio(each.region) for each in self.sightings])
        caps = np.array([model.clutter.most_log_odds(each.region) for each in self.sightings])
        self.tracks.update(self.sightings, ratios, caps, self.level_m)
        claimed = self._claimed(picture.shape)
        self._uncover(picture, left.reshape(picture.shape), claimed)
        model.clutter.learn([each.region for each in self.sightings], claimed)
        model.memory.learn(left, claimed.ravel())
        filters.learn(scaled, claimed, self._noise_rate)
        self._frame += 1

    def answers(self, shown: float, standing: float) -> list[Track]:
        """Return the intruders that exist with a probability of ``shown`` at least.

        That of a track that began on the first pictures and has never moved is ``standing`` at most. Picture after
        picture it shows the same difference from the background, which is no further evidence: a day that is unlike
        those before makes posts and parked cars stand out from the first picture on.
        """
        answers = []
        for mark in self.tracks.marks:
            estimate, confidence = self._estimate(mark), mark.intruder_probability
            if mark.from_start and not mark.has_moved:
                confidence = min(confidence, standing)
            if confidence >= shown and estimate is not None and mark.kind is not BIRD:
                answers.append(Track(mark.identity, estimate, mark.kind.name, mark.size_m, confidence))
        return answers

    def _uncover(self, picture: Picture, left: Picture, claimed: NDArray[np.uint8]) -> None:
        """Take what shows where a parked car has driven off for the background, whatever seems to stand there."""
        standing = self.tracks.standing()
        if not standing and not self._parked.any:
            return
        noise = np.sqrt(self._model.memory.noise).reshape(left.shape)
        background = picture - left + self._model.memory.slow.reshape(left.shape)
        gone = list(self._parked.left(left, noise))
        for mark in standing:
            if shows_background_behind(picture, background, noise, mark.seen_px):
                gone.append(with_rim(mark.seen_px, left.shape))
                self.tracks.drop(mark)
        for x0, y0, x1, y1 in gone:
            self._model.memory.uncover(self._numbers[y0:y1, x0:x1].ravel())
            claimed[y0:y1, x0:x1] = 0
        self._parked.look([mark for mark in self.tracks.marks if mark.kind is CAR and mark.is_settled], left)

    def _claimed(self, shape: tuple[int, ...]) -> NDArray[np.uint8]:
        """Return the pixels (H, W) of tracks that likely exist: what stands there is not background."""
        claimed = np.zeros(shape, np.uint8)
        for mark in self.tracks.marks:
            if mark.probability >= self._claims:
                estimate = self._estimate(mark)
                for box in (mark.seen_px, None if estimate is None else estimate.box_xyxy):
                    if box is not None:
                        x0, y0, x1, y1 = np.clip(np.add(np.round(box), _BOX_RIM_PX), 0, max(shape)).astype(int)
                        claimed[y0:y1, x0:x1] = 1
        return claimed

    def _estimate(self, mark: Mark) -> Estimate | None:
        size_m = mark.size_m
        base_m = self.level_m if mark.afloat else 0.0
        centre_m = np.array([*mark.state[:2], base_m + 0.5 * size_m[2]])
        return self._view.estimate_of(centre_m, size_m, mark.heading.likeliest_rad)
