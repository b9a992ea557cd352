"""Alarms where intruders often are, whatever there is to see: now and then, or all the time."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from trackers.registry import register, tunable
from trackers.site import Site, Surveyed
from trackers.types import CameraModel, Observation, SiteSurvey, Track

PLACES_FILE = "harbour_places.json"
PLACE_COLUMNS = ("ahead_m", "left_m", "up_m", "length_m", "width_m", "height_m", "visits")
"""Of a place: mean offset of intruders' centres from that of the watched volume, their mean size, and their number."""


class VisitedPlaces(Surveyed):
    """Where intruders were in episodes of development seeds, as tracks before any camera over such a site.

    The confidence of a track is the share of its place beside that of the most visited one.
    """

    def __init__(self) -> None:
        stored = json.loads(resources.files("trackers.blind").joinpath(PLACES_FILE).read_text())
        self._places = np.array(stored["places"], dtype=np.float64).reshape(-1, len(PLACE_COLUMNS))
        self._site: Site | None = None

    @property
    def visits(self) -> NDArray[np.float64]:
        """Number of intruders at each place (P,)."""
        return self._places[:, -1]

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """Survey the site anew."""
        self._site = self._site_of(camera, background)

    def tracks(self, observation: Observation, alarms: Iterable[tuple[int, int]]) -> list[Track]:
        """Return the alarms, each an identity and the index of a place, as tracks; none of places behind the camera."""
        if self._site is None:
            self._site = self._site_of(observation.camera, [observation])
        site = self._site
        found = () if site is None else (self._track(identity, place, site) for identity, place in alarms)
        return [track for track in found if track is not None]

    def _track(self, identity: int, place: int, site: Site) -> Track | None:
        row, volume = self._places[place], site.volume
        centre_m = volume.centre_m + row[:3] @ volume.axes
        heading_rad = float(np.arctan2(volume.axes[0, 1], volume.axes[0, 0]))
        estimate = site.view.estimate_of(centre_m, row[3:6], heading_rad)
        if estimate is None:
            return None
        return Track(identity, estimate, size_m=row[3:6], confidence=float(row[6] / self.visits.max()))


@dataclass(frozen=True)
class HarbourBlindParameters:
    """Parameters of ``harbour_blind``.

    Attributes:
        alarms_per_hour: that begin.
        pictures: for which one lasts.
    """

    alarms_per_hour: float = tunable(100.0, 1.0, 1000.0, log=True)
    pictures: int = tunable(15, 4, 200)


@register("harbour_blind", role="blind", summary="alarms now and then where intruders often are", suites=("harbour",))
class HarbourBlind:
    """Draws places by how many intruders were there; it sees no picture."""

    Parameters = HarbourBlindParameters

    def __init__(self, parameters: HarbourBlindParameters, rng: np.random.Generator) -> None:
        self._parameters, self._rng = parameters, rng
        self._places = VisitedPlaces()
        self._begin()

    def survey(self, site: SiteSurvey) -> None:
        """See ``SiteTracker``."""
        self._places.survey(site)

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._places.start(background, camera)
        self._begin()

    def _begin(self) -> None:
        self._time_s: float | None = None
        self._pictures = 0
        self._alarms: list[tuple[int, int, int]] = []
        self._identities = 0

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        p, visits = self._parameters, self._places.visits
        since_s = 0.0 if self._time_s is None else observation.time_s - self._time_s
        self._time_s = observation.time_s
        expected = p.alarms_per_hour * min(max(since_s, 0.0), 60.0) / 3600.0
        for _ in range(self._rng.poisson(expected)):
            place = int(self._rng.choice(len(visits), p=visits / visits.sum()))
            self._alarms.append((self._identities, place, self._pictures + p.pictures))
            self._identities += 1
        self._alarms = [alarm for alarm in self._alarms if alarm[2] > self._pictures]
        self._pictures += 1
        return self._places.tracks(observation, [(identity, place) for identity, place, _ in self._alarms])


@dataclass(frozen=True)
class HarbourPostsParameters:
    """Parameters of ``harbour_posts``.

    Attributes:
        posts: number of the most visited places at which an alarm stands.
    """

    posts: int = tunable(30, 1, 60)


@register("harbour_posts", role="blind", summary="an alarm at each of the most visited places", suites=("harbour",))
class HarbourPosts:
    """One alarm stands at each of the most visited places from first to last; it sees no picture."""

    Parameters = HarbourPostsParameters

    def __init__(self, parameters: HarbourPostsParameters, rng: np.random.Generator) -> None:
        self._places = VisitedPlaces()
        order = np.argsort(-self._places.visits, kind="stable")
        self._posts = [(int(place), int(place)) for place in order[: parameters.posts]]

    def survey(self, site: SiteSurvey) -> None:
        """See ``SiteTracker``."""
        self._places.survey(site)

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._places.start(background, camera)

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return self._places.tracks(observation, self._posts)
