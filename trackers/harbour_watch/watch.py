"""The watch over one learnt site, picture by picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.classes import BIRD, CAR
from trackers.harbour_watch.mark import Mark
from trackers.harbour_watch.parked import Parked, shows_background_behind, with_rim
from trackers.harbour_watch.sightings import Sighting, place_regions
from trackers.harbour_watch.site_model import Picture, SiteModel
from trackers.harbour_watch.tracks import Rates, Tracks
from trackers.site.view import SiteView
from trackers.types import Estimate, Track

_LEVEL_EVERY = 15
_USUAL_STEP_S, _LONGEST_STEP_S = 2.0, 30.0
_RIM_PX = (-2, -2, 3, 3)


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
                        x0, y0, x1, y1 = np.clip(np.add(np.round(box), _RIM_PX), 0, max(shape)).astype(int)
                        claimed[y0:y1, x0:x1] = 1
        return claimed

    def _estimate(self, mark: Mark) -> Estimate | None:
        size_m = mark.size_m
        base_m = self.level_m if mark.afloat else 0.0
        centre_m = np.array([*mark.state[:2], base_m + 0.5 * size_m[2]])
        return self._view.estimate_of(centre_m, size_m, mark.heading.likeliest_rad)
