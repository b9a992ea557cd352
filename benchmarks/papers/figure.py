"""The paper's figure, from our world: the paper's frames, the observed frame inside the larger view."""

from __future__ import annotations

from pathlib import Path

from benchmarks.papers.experiment import PaperExperiment
from benchmarks.report.pictures import Picture, read_pictures, write_picture
from benchmarks.run.jobs import Job, opened
from benchmarks.run.replay import replay
from benchmarks.run.steering import link_in
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
        settings = {tracker: (tracker, experiment.settings[tracker])}
        episode = (experiment.suite, scenario, experiment.preset, renderer, seed, experiment.controller)
        with opened(Job(*episode, (tracker,), link=link_in(experiment.suite), repeats=1, settings=settings)) as live:
            count = min(max(experiment.frames) + 1, live.loop.episode.frame_count)
            seen = replay(live, scale=_SCALE, wanted=experiment.frames, frame_count=count)
            rows[tracker] = list(seen)
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
