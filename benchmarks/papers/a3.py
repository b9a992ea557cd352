"""Paper experiment A.3: a model of the background during frame-outs, with unknown helicopter motion."""

from __future__ import annotations

from benchmarks.papers.claims import Claim
from benchmarks.papers.tracker_experiment import TrackerExperiment

_COUNTED = "of the frame-outs {}, those after which it is on the car again and still is one second later"

EXPERIMENT = TrackerExperiment(
    name="A3",
    title="Paper A, experiment 2: a model of the background, helicopter motion unknown",
    setting="A town with crossings, buildings and other cars; car and helicopter on set paths. The helicopter's "
    "motion is estimated from the picture; road, other ground and buildings show where a car may be. The "
    "method has its written parameters, not the tuned ones.",
    suite="frame-out",
    scenario="road-town-v1",
    preset="paper-a3",
    trackers=("background_pf",),
    frames=(40, 80, 120, 160),
    claims=(
        Claim(
            "road_kept_rate",
            _COUNTED.format("on the road"),
            "the car is followed, to some extent, after it has left the picture",
            "at least",
            0.7,
            tracker="background_pf",
        ),
        Claim(
            "excursion_kept_rate",
            _COUNTED.format("with a way off the road"),
            "tracking fails where the car leaves the road",
            "at most",
            0.3,
            tracker="background_pf",
        ),
    ),
)
