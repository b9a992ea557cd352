"""The paper's figure, from our world: the paper's frames, the observed frame inside the larger view."""

from __future__ import annotations

from pathlib import Path

from benchmarks.papers.experiment import PaperExperiment
from benchmarks.report.pictures import Picture, read_pictures, write_picture
from benchmarks.run.replay import Run
from benchmarks.suites.registry import suite
from benchmarks.video.contact_sheet import contact_sheet
from scenarios import catalog
from scenarios.scenario import RendererName

_SCALE = 3.0
_TITLE = "The paper's figure, in this world"


def paper_figure(experiment: PaperExperiment, out: Path, seed: int, renderer: RendererName) -> Picture:
    """Live through one episode with each method, write the figure beside the rows and return it."""
    scenario = catalog.scenario(suite(experiment.suite).scenes[0].scenario).id
    rows = {}
    for tracker in experiment.trackers:
        run = Run(
            scenario, experiment.preset, seed, renderer, tracker, experiment.controller, experiment.settings[tracker]
        )
        episode = run.open()
        try:
            count = min(max(experiment.frames) + 1, episode.frame_count)
            rows[tracker] = list(run.instants(episode, scale=_SCALE, wanted=experiment.frames, frame_count=count))
        finally:
            episode.close()
    frames = ", ".join(map(str, experiment.frames))
    caption = (
        f"Frames {frames}, as in the paper's figure, of seed {seed}. White: what the camera sees; what is around "
        "it is shown to you alone. Blue: the car. Orange: the estimate. Yellow: the particles. An arrow at the "
        "border points at what lies beyond."
    )
    condition = (experiment.suite, scenario, experiment.preset, renderer, experiment.controller or "")
    name = f"paper-{experiment.name.lower()}-{renderer}"
    write_picture(out, name, contact_sheet(rows), condition, _TITLE, caption, made_from=f"seed {seed}")
    return next(picture for picture in read_pictures(out) if picture.caption == caption)
