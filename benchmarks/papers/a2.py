"""Paper experiment A.2: the road's shape as a model during a frame-out."""

from __future__ import annotations

from benchmarks.papers.claims import Claim
from benchmarks.papers.tracker_experiment import TrackerExperiment

_COUNTED = "runs in which it is on the car again after the frame-out, and still is one second later"

EXPERIMENT = TrackerExperiment(
    name="A2",
    title="Paper A, A2, its experiment 1: the shape of the road, helicopter motion measured",
    setting="A car on a set route; a simple controller keeps the estimate in the middle of the picture. A gust "
    "puts the car outside the picture while the road bends. A plain colour particle filter against one that "
    "extrapolates the road; both move their particles with the measured helicopter motion. Both have their written "
    "parameters, not the tuned ones.",
    suite="frame-out",
    scenario="road-town-v1",
    preset="paper-a2",
    trackers=("colour_pf", "road_shape_pf"),
    frames=(10, 65, 80),
    controller="centre",
    claims=(
        Claim(
            "kept_run_rate",
            _COUNTED,
            "the particles spread out; the car is lost at the frame-out",
            "at most",
            0.2,
            tracker="colour_pf",
        ),
        Claim(
            "kept_run_rate",
            _COUNTED,
            "many particles stay near the car, and the helicopter follows it round a bend outside the picture",
            "at least",
            0.9,
            tracker="road_shape_pf",
        ),
    ),
)
