"""MP4 files of episodes, drawn as their scenario says: the observed frame inside a larger view, a stereo pair …"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from benchmarks.run.replay import Run
from benchmarks.video.caption import Caption
from benchmarks.video.drawing import Drawing, drawing_of
from benchmarks.video.instant import Instant
from benchmarks.video.mp4 import Mp4Writer
from scenarios import catalog
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
        tracker: name of the tracker (or oracle) whose estimate is drawn, or None for truth alone.
        controller: name of what steers by the tracker's estimate (closed loop), or None for a set path.
        frames: stop after so many frames; None = the whole episode.
        scale: size of the larger view relative to the observed frame, >= 1; where the scenario is shown in one.

    Raises:
        ValueError: names the parameter, what was expected and what came.
    """
    if scale < 1:
        raise ValueError(f"scale: expected a number >= 1, got {scale}")
    if frames is not None and frames < 1:
        raise ValueError(f"frames: expected a whole number >= 1, got {frames}")
    if out.suffix != ".mp4":
        raise ValueError(f"out: expected a file that ends in .mp4, got {str(out)!r}")
    run = Run(catalog.scenario(scenario).id, preset, seed, renderer, tracker, controller)
    episode = run.open()
    try:
        count = episode.frame_count if frames is None else min(frames, episode.frame_count)
        title = " · ".join([run.scenario, preset, f"seed {seed}", *filter(None, (tracker, controller))])
        drawing = drawing_of(run.scenario, episode)
        shown_scale = scale if drawing.uses_larger_view else 1.0
        instants = run.instants(episode, scale=shown_scale, wanted=range(count), frame_count=count)
        write_video(out, instants, drawing, rate_hz=episode.rate_hz, title=title, frame_count=count)
    finally:
        episode.close()
    return out


def write_video(
    out: Path, instants: Iterable[Instant], drawing: Drawing, *, rate_hz: float, title: str, frame_count: int
) -> None:
    """Write instants as an MP4, under each a caption with ``title`` and a time line of ``frame_count``."""
    caption = None
    with Mp4Writer(out, rate_hz) as video:
        for instant in instants:
            picture = drawing.picture(instant)
            caption = caption or Caption(drawing, title, frame_count, picture.shape[1])
            video.write(np.concatenate([picture, caption.draw(instant)]))
