"""Reduction of a tracker of many targets to one target, for suites of one target and for envs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackers.estimate_check import check_tracks
from trackers.protocols import MultiTracker, OutsourcingTracker, begin
from trackers.types import Estimate, Observation, SiteSurvey, Start, Track

_CONFIDENT = 0.5
"""Confidence from which a track is taken to exist; a track without one is."""
_PATIENCE_S = 0.5
"""How long a followed track may be away, or unlikely, before another one is taken for the target."""
_VELOCITY_S = 1.0
"""Time constant of the velocity's running mean, and of its decay while the target is away."""
_SIDES_PER_S = 1.5
"""How fast the target may stray from where it is expected, in longest sides of its box a second."""
_MOST_SIDES = 6.0
"""How far from there it is looked for at most, in longest sides of its box."""
_BESIDE_SIDES, _LEAVES_SIDES = 1.0, 1.5
"""Distances from the followed track, in longest sides of its box, up to which another one begins beside it, and at
which that one has left it."""
_STILL_SIDES = 0.3
"""Way of a followed track, in longest sides of its box, up to which it has stayed where it was."""


class FollowOne:
    """A ``Tracker`` that returns one track of a ``MultiTracker``.

    It is the track nearest to the centre of the target's first box, and inside it, on the first picture with such a
    track; one that begins later may have left it. Its identity is followed; on pictures without it the estimate is NaN.
    Two things end that:

    * It is away, or unlikely, for longer than 0.5 s. The target is then the confident track nearest to where it is
      expected, within a distance that grows with time, of the kind that its track had most often. That is a guess: a
      track that later has the identity of the target before it takes its place.
    * It stays where it is, and a track of its kind that began beside it leaves: what stays is what the target left
      behind in the background.

    A track that was seen apart from the target is another object and is not taken for it, unless the target had that
    identity.
    """

    def __init__(
        self, tracker: MultiTracker, background: Sequence[Observation] = (), site: SiteSurvey | None = None
    ) -> None:
        """``background``, ``site``: see ``Start``."""
        self._tracker = tracker
        self._background, self._site = tuple(background), site
        self._box_xyxy = np.zeros(4)
        self._velocity_px_s = np.zeros(2)
        self._known_s, self._watched_s = 0.0, 0.0
        self._kinds: Counter[str] = Counter()
        self._identity: int | None = None
        self._others: set[int] = set()
        self._before: list[int] = []
        self._beside: dict[int, NDArray[np.float64]] = {}

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        self._box_xyxy, self._known_s = np.asarray(box_xyxy, dtype=float), observation.time_s
        begin(self._tracker, Start(observation.camera, background=self._background, site=self._site))
        self.update(observation)

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        tracks = check_tracks(self._tracker.update(observation), observation.camera)
        confident = [track for track in tracks if _is_confident(track)]
        followed = _of(confident, self._identity)
        away_s = observation.time_s - self._known_s
        if (again := self._known_again(confident)) is not None:
            followed = again
        elif followed is not None:
            followed = self._track_that_left(followed, confident) or followed
        elif self._identity is None or away_s > _PATIENCE_S:
            followed = self._likeliest(confident, away_s)
            if followed is not None and self._identity is not None:
                self._before.append(self._identity)
        if followed is not None:
            self._note(followed, confident, observation.time_s)
        elif self._identity is None:
            self._others.update(each.identity for each in confident)
        track = _of(tracks, self._identity)
        return Estimate(position_px=np.full(2, np.nan)) if track is None else track.estimate

    @property
    def elsewhere_cpu_s(self) -> float:
        """See ``OutsourcingTracker``."""
        return self._tracker.elsewhere_cpu_s if isinstance(self._tracker, OutsourcingTracker) else 0.0

    @property
    def _middle_px(self) -> NDArray[np.float64]:
        middle: NDArray[np.float64] = 0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:])
        return middle

    @property
    def _side_px(self) -> float:
        return float((self._box_xyxy[2:] - self._box_xyxy[:2]).max())

    def _known_again(self, tracks: Sequence[Track]) -> Track | None:
        """Return the track of the first identity that the target had, of those for which another one was guessed."""
        for k, identity in enumerate(self._before):
            if (track := _of(tracks, identity)) is not None:
                del self._before[k:]
                return track
        return None

    def _likeliest(self, tracks: Sequence[Track], away_s: float) -> Track | None:
        """Return the track of the target, which has not been known for ``away_s``."""
        decayed_s = _VELOCITY_S * (1.0 - np.exp(-away_s / _VELOCITY_S))
        expected_px = self._middle_px + self._velocity_px_s * decayed_s
        reach_px = min(_SIDES_PER_S * away_s, _MOST_SIDES) * self._side_px
        near = []
        for each in tracks:
            is_first = self._identity is None and self._is_in_box(each)
            is_new = each.identity not in self._others and _distance_px(each, expected_px) <= reach_px
            if is_first or (is_new and self._is_alike(each)):
                near.append(each)
        return _nearest(near, expected_px)

    def _is_in_box(self, track: Track) -> bool:
        place_px = track.estimate.position_px
        return bool(((self._box_xyxy[:2] <= place_px) & (place_px <= self._box_xyxy[2:])).all())

    def _track_that_left(self, followed: Track, tracks: Sequence[Track]) -> Track | None:
        """Return the track that began beside the followed one and left it, which stays."""
        place_px = followed.estimate.position_px
        for each in tracks:
            began_px = self._beside.get(each.identity)
            if began_px is not None and _distance_px(each, place_px) > _LEAVES_SIDES * self._side_px:
                del self._beside[each.identity]
                if _distance_px(followed, began_px) <= _STILL_SIDES * self._side_px:
                    self._others.discard(each.identity)
                    return each
                self._others.add(each.identity)
        return None

    def _is_alike(self, track: Track) -> bool:
        return not self._kinds or track.kind is None or track.kind == self._kinds.most_common(1)[0][0]

    def _note(self, followed: Track, tracks: Sequence[Track], time_s: float) -> None:
        """Store the target's latest state, and the identities of other objects."""
        place_px, dt_s = followed.estimate.position_px, time_s - self._known_s
        if followed.identity != self._identity:
            self._others.discard(followed.identity)
            if self._identity is not None:
                self._others.add(self._identity)
            self._identity, self._beside = followed.identity, {}
        elif dt_s > 0:
            self._watched_s += dt_s
            share = max(1.0 - np.exp(-dt_s / _VELOCITY_S), dt_s / self._watched_s)
            self._velocity_px_s += share * ((place_px - self._middle_px) / dt_s - self._velocity_px_s)
        half_px = 0.5 * (self._box_xyxy[2:] - self._box_xyxy[:2])
        box = followed.estimate.box_xyxy
        self._box_xyxy = np.concatenate([place_px - half_px, place_px + half_px]) if box is None else np.asarray(box)
        self._known_s = time_s
        if followed.kind is not None:
            self._kinds[followed.kind] += 1
        for each in tracks:
            if each.identity in self._others or each.identity in self._beside or each is followed:
                continue
            if self._is_alike(each) and _distance_px(each, place_px) <= _BESIDE_SIDES * self._side_px:
                self._beside[each.identity] = place_px
            else:
                self._others.add(each.identity)


def _is_confident(track: Track) -> bool:
    sure = track.confidence is None or track.confidence >= _CONFIDENT
    return sure and bool(np.isfinite(track.estimate.position_px).all())


def _of(tracks: Sequence[Track], identity: int | None) -> Track | None:
    return next((track for track in tracks if track.identity == identity), None)


def _distance_px(track: Track, place_px: NDArray[np.float64]) -> float:
    return float(np.hypot(*(track.estimate.position_px - place_px)))


def _nearest(tracks: Sequence[Track], place_px: NDArray[np.float64]) -> Track | None:
    return min(tracks, key=lambda track: (_distance_px(track, place_px), track.identity), default=None)
