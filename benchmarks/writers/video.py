"""MP4 files of episodes: the observed frame as a box inside the larger view, as in the papers."""

from __future__ import annotations

from pathlib import Path

from benchmarks.writers.replay import write_video
from scenarios import catalog
from scenarios.scenario import Episode, RendererName, Scenario
from sim.rng import generator
from trackers import registry
from trackers.controllers.catalogue import create_controller
from trackers.protocols import Tracker


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
        controller: name of what steers by the tracker's estimate (closed loop), or None for a set path.
        frames: stop after so many frames; None = the whole episode.
        scale: size of the larger view relative to the observed frame, >= 1.

    Raises:
        ValueError: names the parameter, what was expected and what came.
    """
    if scale < 1:
        raise ValueError(f"scale: expected a number >= 1, got {scale}")
    if frames is not None and frames < 1:
        raise ValueError(f"frames: expected a whole number >= 1, got {frames}")
    if controller is not None and tracker is None:
        raise ValueError(f"tracker: expected a name, as controller {controller!r} steers by one; got none")
    source = catalog.scenario(scenario)
    episode = open_episode(source, preset, seed, renderer, closed_loop=controller is not None)
    try:
        follower = None if tracker is None else create_tracker(tracker, source, seed)
        pilot = None if controller is None else create_controller(controller)
        count = episode.frame_count if frames is None else min(frames, episode.frame_count)
        title = " · ".join([source.id, preset, f"seed {seed}", *filter(None, (tracker, controller))])
        write_video(out, episode, follower, pilot, title=title, frame_count=count, scale=scale)
    finally:
        episode.close()
    return out


def open_episode(
    source: Scenario, preset: str, seed: int, renderer: RendererName, *, closed_loop: bool
) -> Episode:
    """Build an episode, closed loop or on its set path."""
    if preset not in source.presets:
        raise ValueError(f"preset: expected one of {', '.join(source.presets)}; got {preset!r}")
    if seed < 0:
        raise ValueError(f"seed: expected a whole number >= 0, got {seed}")
    return source.episode(preset, seed, renderer=renderer, closed_loop=closed_loop)


def create_tracker(name: str, source: Scenario, seed: int) -> Tracker:
    """Return the tracker as the benchmark starts it on this episode."""
    return registry.entry(name).create(generator(seed, f"tracker/{source.id}/{name}/0"))
