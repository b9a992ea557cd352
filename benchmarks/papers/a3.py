"""Paper experiment A.3: does a model of the background carry a tracker through frame-outs, motion unknown?"""

from __future__ import annotations

from pathlib import Path

from benchmarks.papers.claims import Claim
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.repeat import repeat
from scenarios.scenario import RendererName

_COUNTED = "of the frame-outs {}, those after which it is on the car again and still is one second later"

EXPERIMENT = PaperExperiment(
    name="A3",
    title="Paper A, experiment 2: a model of the background, helicopter motion unknown",
    setting="A town with crossings, buildings and other cars; car and helicopter on set paths. The helicopter's "
    "motion is estimated from the picture; where a car may be is told by road, other ground and buildings. The method "
    "is set as it was written, whatever `frameout tune` found.",
    preset="paper-a3",
    trackers=("background_pf",),
    frames=(40, 80, 120, 160),
    controller=None,
    claims=(
        Claim(
            "road_kept_rate",
            "the car is followed, to some extent, after it has left the picture",
            _COUNTED.format("on the road"),
            "at least",
            0.7,
            tracker="background_pf",
        ),
        Claim(
            "excursion_kept_rate",
            "tracking fails where the car leaves the road",
            _COUNTED.format("with a way off the road"),
            "at most",
            0.3,
            tracker="background_pf",
        ),
    ),
)


def run(out: Path, seeds: range, renderer: RendererName, workers: int) -> None:
    """Run the experiment, print its table beside the paper's words, write rows, pictures and ``out/paper.html``.

    Args:
        out: folder for rows, pictures and page; a second call with the same arguments resumes.
        seeds: episodes to run; 10,000 to 19,999 are the test split.
        renderer: ``raster`` or ``pybullet``.
        workers: processes.
    """
    repeat(EXPERIMENT, out, seeds, renderer, workers)
