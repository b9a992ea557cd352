"""MP4 files of episodes with the drawing of their scenario, e.g. the observed frame inside a larger view."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from benchmarks.run.episodes import Simulated
from benchmarks.run.experiment import Progress
from benchmarks.run.failures import Failure
from benchmarks.run.jobs import Job, opened
from benchmarks.run.result_folder import make_folder
from benchmarks.show.replay import replay
from benchmarks.show.showing import drawing_of
from benchmarks.show.video.caption import Caption
from benchmarks.show.video.drawing import Drawing
from benchmarks.show.video.instant import Instant
from benchmarks.show.video.mp4 import Mp4Writer
from sim.checks import check

MOST_PIXELS = 4096 * 4096
"""Limit of a larger view, whose buffers and encoder then take 2 GB."""


def render_episode(
    job: Job,
    out: Path,
    *,
    frames: int | None = None,
    scale: float = 2.0,
    progress: Progress = lambda done, of: None,
) -> list[Failure]:
    """Write the episode of a job as an MP4; return the failures in it.

    Args:
        job: gives the pictures and, with trackers, the estimates of the first.
        out: file (H.264 in MP4), written atomically.
        frames: number of frames; None = the whole episode.
        scale: size of the larger view relative to the observed frame, >= 1, of at most 16,777,216 pixels; for
            scenarios shown in one.
        progress: called with the number of frames written, and of all.

    Raises:
        ValueError: names the parameter, what was expected and what came.
    """
    check("scale", scale >= 1, "a number >= 1", scale)
    spec = job.episode
    assert isinstance(spec, Simulated)
    shown = spec.configuration
    pixels = scale**2 * shown.width_px * shown.height_px
    check("scale", pixels <= MOST_PIXELS, f"a larger view of at most {MOST_PIXELS:,} pixels", f"{pixels:,.0f}")
    check("frames", frames is None or frames >= 1, "a whole number >= 1", frames)
    check("out", out.suffix == ".mp4" and not os.path.isdir(out), "a file that ends in .mp4", repr(str(out)))
    make_folder(out.parent)
    with opened(job) as live:
        episode = live.loop.episode
        count = episode.frame_count if frames is None else min(frames, episode.frame_count)
        by = spec.steering
        steered = [] if by is None else [by.name, *([f"{by.link} link"] if by.link else [])]
        title = " · ".join([spec.scenario_id, spec.preset, f"seed {spec.seed}", *job.trackers, *steered])
        drawing = drawing_of(spec.scenario_id, episode)
        shown_scale = scale if drawing.uses_larger_view else 1.0
        instants = replay(live, scale=shown_scale, wanted=range(count), frame_count=count)
        instants = _counted(instants, count, progress)
        write_video(out, instants, drawing, rate_hz=episode.rate_hz, title=title, frame_count=count)
        return live.failures()


def _counted(instants: Iterable[Instant], count: int, progress: Progress) -> Iterator[Instant]:
    """Yield the instants; a frame is reported when the next one is asked for, since it is then written."""
    progress(0, count)
    for done, instant in enumerate(instants, 1):
        yield instant
        progress(done, count)


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
