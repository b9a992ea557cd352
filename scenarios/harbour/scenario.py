"""The scenario ``harbour-v1``: a harbour through a thermal camera; people, cars and boats come and go.

There is one site. All presets and both splits of seeds share its quay, berths, sheds, bays and lamp posts, the camera's
place and its pattern of pixels; episodes differ in weather, tide, boats, looks and ways. What was learnt on development
seeds was learnt on this site: the confidences of ``harbour_mog2``, ``harbour_knn``, ``harbour_median`` and
``eigen_swarm_learnt_confidence``, the places of ``harbour_blind`` and ``harbour_posts``, the values in
``trackers/tuned``, the settings of ``harbour_watch`` and what paper D leaves open of ``eigen_swarm``, the controllers'
for the second camera. A test episode has weather and intruders that nobody has seen, never a place: no figure says how
any of them does at another harbour, where all but the pictures without intruders and the survey would be taken along.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from scenarios.harbour.episode import TARGET, HarbourEpisode
from scenarios.harbour.head import HEAD
from scenarios.harbour.presets import PRESETS, Harbour
from scenarios.harbour.truth import HarbourTruth
from scenarios.scenario import RendererName, preset_of
from scenarios.truth import TruthExtent
from sim.rng import episode_seed
from trackers.types import Carrier


@dataclass(frozen=True)
class HarbourScenario:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "harbour-v1"
    summary: str = "a harbour through a thermal camera; people, cars and boats come and go"
    start: str = (
        "pictures of three earlier days without intruders, the surveyed pose of the camera, and the survey of the "
        "site: quay, mean water, watched volume"
    )
    target: str = TARGET
    truth: type[HarbourTruth] = HarbourTruth
    classes: Mapping[str, str] = field(default_factory=lambda: {kind: kind for kind in ("person", "car", "boat")})
    carrier: Carrier = HEAD
    pictureless: None = None
    presets: dict[str, Harbour] = field(default_factory=lambda: dict(PRESETS))

    def episode(
        self,
        preset: str | Harbour,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> HarbourEpisode:
        """Build one episode.

        Args:
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands steer the second camera, which follows the first of ``patrols``, of whom there
                then is at least one; None = as in the preset.
            truth: ``target`` leaves out expensive fields that scores of following do not use, see ``Truth``.

        Raises:
            ValueError: for an unknown preset or renderer, or a negative seed.
        """
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        if looped:
            # A camera that follows needs someone to follow from the first picture on.
            configuration = replace(configuration, patrols=max(configuration.patrols, 1))
        return HarbourEpisode(configuration, episode_seed(seed, self.id, 0), renderer, looped, truth)


HARBOUR = HarbourScenario()
