"""Where a tracker of a site stands: its survey, and its camera's view from the first pose that it is told."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.site.view import SiteView
from trackers.site.volume import PlacedVolume, place
from trackers.types import CameraModel, Observation, SiteSurvey


@dataclass(frozen=True, eq=False)
class Site:
    """A surveyed site, a camera at rest over it, and the volume that it watches."""

    survey: SiteSurvey
    view: SiteView
    volume: PlacedVolume


class Surveyed:
    """The part of a ``SiteTracker`` that takes in the survey."""

    _survey: SiteSurvey | None = None

    def survey(self, site: SiteSurvey) -> None:
        """See ``SiteTracker``."""
        self._survey = site

    def _site_of(self, camera: CameraModel, observations: Iterable[Observation]) -> Site | None:
        """Return the site by the first of ``observations`` whose measured pose can be used; None if there is none.

        A pose can be used if its optical axis meets the ground ahead, see ``place``.

        Raises:
            ValueError: before ``survey``.
        """
        known = self._known()
        for observation in observations:
            if observation.ego is not None:
                try:
                    return placed(known, camera, observation.ego.T_world_camera)
                except ValueError:
                    continue  # The instruments failed on this picture.
        return None

    def _known(self) -> SiteSurvey:
        if self._survey is None:
            raise ValueError("site: expected a survey of the site before the start, got none")
        return self._survey


def placed(survey: SiteSurvey, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> Site:
    """Return the site before a camera. Raises ValueError as ``place``."""
    return Site(survey, SiteView(camera, T_world_camera), place(survey, camera, T_world_camera))
