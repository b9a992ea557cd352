"""``frameout paper``: repeat a paper's experiment."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import FOLDER, WORKERS, UsualSeeds
from benchmarks.contract.rows import FILE_NAME, read_rows
from benchmarks.papers.experiment import NAMES, PaperExperiment, experiment_named
from benchmarks.papers.repeat import repeat
from benchmarks.run.selection import check_renderer
from benchmarks.run.workers import cores
from sim.checks import check, check_choice


@dataclass(frozen=True)
class Paper:
    """Repeat a paper's experiment over many episodes; show its table beside ours, with pictures at the paper's frames.

    The methods have the parameters of the paper, as under their own names in `frameout bench`, where NAME_tuned has the
    tuned ones. B1 and B2 measure a camera and run no method.

    Attributes:
        experiment: A2: a car is tracked by the shape of the road, the helicopter's motion is measured; A3: by pixel
            classes, the motion is unknown; B1: colours and camera settings under a dimmed lamp; B2: when colour can be
            learnt; B3: a person is followed by stereo under changing light; C: lost pieces of a fish's track; D:
            intruders before a thermal camera.
        seeds: episodes A to B - 1, or A alone (default: 10000:10050; for B3 10000:10010, as many frames as in the
            paper; for D 10000:10010, each as long as the paper's).
        renderer: raster or pybullet.
        out: folder for rows, pictures and page of this experiment alone (default: results/paper-a2 …).
        workers: number of worker processes.
    """

    experiment: Annotated[str, tyro.conf.Positional]
    seeds: UsualSeeds = None
    renderer: str = "raster"
    out: Annotated[Path | None, FOLDER] = None
    workers: Annotated[int | None, WORKERS] = None
    resumes = True

    def run(self) -> int:
        """Run it; return the exit status. Raises ValueError for wrong arguments and a folder of something else."""
        name = self.experiment.upper()
        check_choice("experiment", name, NAMES)
        renderer, experiment = check_renderer(self.renderer), experiment_named(name)
        out = self.out or Path("results") / f"paper-{name.lower()}"
        _check_folder(out, experiment)
        repeat(experiment, out, self.seeds or experiment.seeds, renderer, cores(self.workers))
        return 0


def _check_folder(out: Path, experiment: PaperExperiment) -> None:
    """Raise ValueError for a folder with rows of something else: it would keep them below this experiment's page."""
    rows = read_rows(out) if (out / FILE_NAME).is_file() else []
    own = {(experiment.suite, experiment.scenario, preset) for preset in experiment.presets}
    others = {(row["suite"], row["scenario"], row["preset"]) for row in rows} - own
    held = "{!r}, which holds rows of suite {}, scenario {}, preset {}".format(str(out), *min(others or own))
    check("out", not others, f"a folder of paper {experiment.name} alone, e.g. an empty one", held)
