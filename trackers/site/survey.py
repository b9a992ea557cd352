"""Where a tracker of a site stands: its camera's view and the watched volume, from the first pose it is told."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from trackers.site.view import SiteView
from trackers.site.volume import PlacedVolume, WatchedVolume, place
from trackers.types import CameraModel, Observation


@dataclass(frozen=True, eq=False)
class Site:
    """A camera at rest and the volume that it watches."""

    view: SiteView
    volume: PlacedVolume


def survey(volume: WatchedVolume, camera: CameraModel, observations: Iterable[Observation]) -> Site | None:
    """Return the site by the first of ``observations`` whose measured pose can be used; None if there is none.

    A pose can be used if its optical axis meets the ground ahead, see ``place``.
    """
    for observation in observations:
        if observation.ego is not None:
            pose = observation.ego.T_world_camera
            try:
                return Site(SiteView(camera, pose), place(volume, camera, pose))
            except ValueError:
                continue  # The instruments failed on this picture.
    return None
