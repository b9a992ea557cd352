"""Alarms where intruders often are, whatever there is to see: now and then, or all the time."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import resources

import numpy as np

from trackers.registry import register, tunable
from trackers.site.survey import Site, survey
from trackers.site.volume import WatchedVolume
from trackers.types import CameraModel, Observation, Track

PLACES_FILE = "harbour_places.json"
PLACE_COLUMNS = ("ahead_m", "left_m", "up_m", "length_m", "width_m", "height_m", "visits")
"""Of a place: mean offset of intruders' centres from that of the watched volume, their mean size, and their number."""


@dataclass(frozen=True)
class HarbourBlindParameters:
    """Parameters of ``harbour_blind``.

    Attributes:
        volume: that is watched.
        alarms_per_hour: that begin.
        pictures: for which one lasts.
    """

    volume: WatchedVolume = field(default_factory=WatchedVolume)
    alarms_per_hour: float = tunable(100.0, 1.0, 1000.0, log=True)
    pictures: int = tunable(15, 4, 200)


@register("harbour_blind", role="blind", summary="alarms now and then where intruders often are", suites=("harbour",))
class HarbourBlind:
    """Draws places by how many intruders were there in episodes of development seeds; it sees no picture.

    The confidence of an alarm is the share of its place beside that of the most visited one.
    """

    Parameters = HarbourBlindParameters
    _site: Site | None

    def __init__(self, parameters: HarbourBlindParameters, rng: np.random.Generator) -> None:
        self._parameters, self._rng = parameters, rng
        stored = json.loads(resources.files("trackers.blind").joinpath(PLACES_FILE).read_text())
        self._places = np.array(stored["places"], dtype=np.float64).reshape(-1, len(PLACE_COLUMNS))
        self._begin(None)

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._begin(survey(self._parameters.volume, camera, background))

    def _site_of(self, observation: Observation) -> Site | None:
        if self._site is None:
            self._site = survey(self._parameters.volume, observation.camera, [observation])
        return self._site

    def _begin(self, site: Site | None) -> None:
        self._site = site
        self._time_s: float | None = None
        self._pictures = 0
        self._alarms: list[tuple[int, int, int]] = []
        self._identities = 0

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        p = self._parameters
        site = self._site_of(observation)
        since_s = 0.0 if self._time_s is None else observation.time_s - self._time_s
        self._time_s = observation.time_s
        expected = p.alarms_per_hour * min(max(since_s, 0.0), 60.0) / 3600.0
        visits = self._places[:, -1]
        for _ in range(self._rng.poisson(expected)):
            place = int(self._rng.choice(len(visits), p=visits / visits.sum()))
            self._alarms.append((self._identities, place, self._pictures + p.pictures))
            self._identities += 1
        self._alarms = [alarm for alarm in self._alarms if alarm[2] > self._pictures]
        self._pictures += 1
        if site is None:
            return []
        tracks = [self._track(identity, place, site) for identity, place, _ in self._alarms]
        return [track for track in tracks if track is not None]

    def _track(self, identity: int, place: int, site: Site) -> Track | None:
        """Return an alarm at a place as a track; None if that lies behind the camera."""
        row, volume = self._places[place], site.volume
        centre_m = volume.centre_m + row[:3] @ volume.axes
        heading_rad = float(np.arctan2(volume.axes[0, 1], volume.axes[0, 0]))
        estimate = site.view.estimate_of(centre_m, row[3:6], heading_rad)
        if estimate is None:
            return None
        return Track(identity, estimate, size_m=row[3:6], confidence=float(row[6] / self._places[:, 6].max()))


@dataclass(frozen=True)
class HarbourPostsParameters(HarbourBlindParameters):
    """Parameters of ``harbour_posts``.

    Attributes:
        posts: number of the most visited places at which an alarm stands.
    """

    posts: int = tunable(30, 1, 60)


@register("harbour_posts", role="blind", summary="an alarm at each of the most visited places", suites=("harbour",))
class HarbourPosts(HarbourBlind):
    """As ``HarbourBlind``, but one alarm stands at each of the most visited places from first to last."""

    Parameters = HarbourPostsParameters
    _parameters: HarbourPostsParameters

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        site = self._site_of(observation)
        if site is None:
            return []
        places = np.argsort(-self._places[:, -1], kind="stable")[: self._parameters.posts]
        tracks = [self._track(int(place), int(place), site) for place in places]
        return [track for track in tracks if track is not None]
