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

from scenarios.harbour.episode import HarbourEpisode
from scenarios.harbour.head import HEAD
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.truth import HarbourTruth
from scenarios.scenario import Scenario

HARBOUR = Scenario(
    id="harbour-v1",
    summary="a harbour through a thermal camera; people, cars and boats come and go",
    start=(
        "pictures of three earlier days without intruders, the surveyed pose of the camera, and the survey of the "
        "site: quay, mean water, watched volume"
    ),
    stage=HarbourEpisode,
    presets=PRESETS,
    classes={kind: kind for kind in ("person", "car", "boat")},
    carrier=HEAD,
    truth=HarbourTruth,
    target="person-0",
)
