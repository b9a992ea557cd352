"""Paper experiment A.2: does knowing the road's shape carry a tracker through a frame-out?"""

from __future__ import annotations

from pathlib import Path

from benchmarks.papers.claims import Claim
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.repeat import repeat
from scenarios.scenario import RendererName

_COUNTED = "runs in which it is on the car again after the frame-out, and still is one second later"

EXPERIMENT = PaperExperiment(
    name="A2",
    title="Paper A, experiment 1: the shape of the road, helicopter motion measured",
    setting="A car on a set route; a simple controller keeps the estimate in the middle of the picture. A gust "
    "puts the car outside the picture while the road bends. A plain colour particle filter against one that "
    "extrapolates the road; both move their particles with the measured helicopter motion. Both are set as they were "
    "written, whatever `frameout tune` found.",
    preset="paper-a2",
    trackers=("colour_pf", "road_shape_pf"),
    frames=(10, 65, 80),
    controller="centre",
    claims=(
        Claim(
            "kept_run_rate",
            "the particles spread out; the car is lost at the frame-out",
            _COUNTED,
            "at most",
            0.2,
            tracker="colour_pf",
        ),
        Claim(
            "kept_run_rate",
            "many particles stay near the car, and the helicopter follows it round a bend outside the picture",
            _COUNTED,
            "at least",
            0.9,
            tracker="road_shape_pf",
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
