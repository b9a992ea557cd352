"""Paper experiment A.2 (road shape, measured motion), repeated over seeds."""

from __future__ import annotations

from pathlib import Path

from scenarios.scenario import RendererName


def run(out: Path, seeds: range, renderer: RendererName, workers: int) -> None:
    """Run the experiment, print its table beside the paper's words, write rows, pictures and ``out/paper.html``.

    Args:
        out: folder for rows, pictures and page; a second call with the same arguments resumes.
        seeds: episodes to run; 10,000 and above are the test split.
        renderer: ``raster`` or ``pybullet``.
        workers: processes.
    """
    raise NotImplementedError
