"""MP4 files of episodes: the observed frame as a box inside the larger view, as the papers' figures draw it."""

from __future__ import annotations

from pathlib import Path

from scenarios.scenario import RendererName


def render_episode(
    scenario: str,
    out: Path,
    *,
    preset: str = "standard",
    seed: int = 0,
    tracker: str | None = None,
    controller: str | None = None,
    renderer: RendererName = "raster",
    frames: int | None = None,
    scale: float = 2.0,
) -> Path:
    """Write one episode as an MP4 and return its path.

    Args:
        scenario: catalogue id, with or without version.
        out: file to write (H.264 in MP4), beside and renamed.
        preset, seed, renderer: which episode.
        tracker: registered name of the tracker whose estimate is drawn, or None for truth alone.
        controller: name of the controller that steers in closed loop, or None for the scenario's default.
        frames: stop after so many frames; None = the whole episode.
        scale: field of the larger view relative to the observed frame, > 1.

    Raises:
        ValueError: names the parameter, what was expected and what came.
    """
    raise NotImplementedError
