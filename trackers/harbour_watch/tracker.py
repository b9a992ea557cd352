"""``harbour_watch``, our own: what the site's background does not explain, tracked with a probability of existence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from trackers.harbour_watch.site_model import ModelParameters, SiteModel
from trackers.harbour_watch.watch import Watch
from trackers.registry import register, register_variant, tunable
from trackers.site.quay import Quay
from trackers.site.reading import Picture, reading_of
from trackers.site.view import SiteView
from trackers.site.volume import WatchedVolume
from trackers.types import CameraModel, EgoPose, Observation, Track


@dataclass(frozen=True)
class WatchParameters:
    """Parameters of ``harbour_watch``.

    Attributes:
        components: of the low-rank background beside the camera's gain and offset.
        remembered_frames, noise_frames: time constants of a pixel's slow residual and of its noise.
        hidden_frames: in which what a pixel showed is forgotten while an object hides it.
        least_score, piece_score: deviations of a region's best box, and of its pieces.
        clip: deviations at which one pixel is cut off.
        claims: probability of existence from which a track's pixels are not learnt; above 1 = never.
        shown: least probability of existence of a track that is answered.
        quay: survey of the site. Of it the mean water level is used; where water is seen is learnt.
        use_counts: False reads the picture after automatic gain control instead.
    """

    components: int = tunable(16, 2, 40)
    remembered_frames: float = tunable(60.0, 10.0, 600.0, log=True)
    noise_frames: float = tunable(80.0, 20.0, 400.0, log=True)
    hidden_frames: float = tunable(6000.0, 100.0, 20000.0, log=True)
    least_score: float = tunable(4.5, 3.5, 7.0)
    piece_score: float = tunable(3.5, 2.0, 6.0)
    clip: float = tunable(6.0, 3.0, 20.0, log=True)
    claims: float = 0.9
    shown: float = 0.01
    quay: Quay = field(default_factory=Quay)
    use_counts: bool = True


@register(
    "harbour_watch",
    role="ours",
    summary="low-rank background of the site, matched boxes, probability of existence",
    suites=("harbour",),
)
class HarbourWatch:
    """A ``MultiTracker`` of people, cars and boats on a quay and the water before it.

    Attributes:
        decides_at: see ``DecidingTracker``; the probability at which its settings were chosen, on development seeds.
    """

    Parameters = WatchParameters
    decides_at = 0.9

    def __init__(self, parameters: WatchParameters, rng: np.random.Generator) -> None:
        self._p = parameters

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``. The site is learnt on the first picture, whose pose it needs."""
        self._background = tuple(background)
        self._watch: Watch | None = None
        self._shape: tuple[int, ...] = ()

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``. Without a measured pose nothing can be placed and there is no track."""
        if observation.ego is None:
            return []
        picture = reading_of(observation, self._p.use_counts)
        if self._watch is None or self._shape != picture.shape:
            self._watch = self._begun(observation, observation.ego, picture)
            self._shape = picture.shape
        self._watch.update(picture, observation.time_s)
        return self._watch.answers(self._p.shown)

    def _begun(self, observation: Observation, ego: EgoPose, picture: Picture) -> Watch:
        """Learn from the background pictures that have the size of ``picture``, or from it alone."""
        shown = [reading_of(each, self._p.use_counts) for each in self._background]
        alike = [each for each in shown if each.shape == picture.shape] or [picture]
        view, p = SiteView(observation.camera, ego.T_world_camera), self._p
        parameters = ModelParameters(
            components=p.components,
            mean_water_m=p.quay.mean_water_m,
            remembered_frames=p.remembered_frames,
            noise_frames=p.noise_frames,
            hidden_frames=p.hidden_frames,
            clip=p.clip,
            least_score=p.least_score,
            piece_score=p.piece_score,
        )
        model = SiteModel(np.array(alike), view, WatchedVolume(), parameters)
        first = 0 if self._watch is None else self._watch.tracks.next_identity
        return Watch(model, view, first, claims=p.claims, clip=p.clip, noise_frames=p.noise_frames)


register_variant("harbour_watch_swallows", "harbour_watch", summary="learns what stands still, objects too", claims=2.0)
register_variant(
    "harbour_watch_8_bit", "harbour_watch", summary="reads the picture after gain control", use_counts=False
)
register_variant(
    "harbour_watch_no_tide", "harbour_watch", summary="no low-rank background: gain and offset alone", components=0
)
