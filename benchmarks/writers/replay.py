"""Live through an episode once more, to look at it: every instant with truth, estimate and larger view."""

from __future__ import annotations

from collections.abc import Container, Iterator
from pathlib import Path

import numpy as np

from benchmarks.writers.caption import Caption
from benchmarks.writers.instant import Instant, draw_instant
from benchmarks.writers.mp4 import Mp4Writer
from scenarios.scenario import Episode
from trackers.protocols import Controller, Tracker
from trackers.types import Estimate


def replay(
    episode: Episode,
    tracker: Tracker | None,
    controller: Controller | None,
    *,
    scale: float,
    wanted: Container[int],
    frame_count: int,
) -> Iterator[Instant]:
    """Yield the ``wanted`` ones among the first ``frame_count`` frames; the others are lived through unseen.

    The tracker is told the target's box in frame 0, where that box is its estimate. The controller's command
    of one frame moves the camera to the next, as when the run was scored.
    """
    command = None
    for index in range(frame_count):
        frame = episode.step(command)
        estimate = None
        if tracker is not None and index == 0:
            tracker.initialise(frame.observation, episode.target_box_xyxy)
            box = episode.target_box_xyxy
            estimate = Estimate(0.5 * (box[:2] + box[2:]), box, in_view_probability=1.0)
        elif tracker is not None:
            estimate = tracker.update(frame.observation)
        if controller is not None and estimate is not None:
            command = controller.command(frame.observation, estimate)
        if index in wanted:
            yield Instant(frame, estimate, episode.larger_view(scale))


def write_video(
    out: Path,
    episode: Episode,
    tracker: Tracker | None,
    controller: Controller | None,
    *,
    title: str,
    frame_count: int,
    scale: float,
) -> None:
    """Write the first ``frame_count`` frames of an episode as an MP4, a caption with ``title`` under each."""
    caption = None
    with Mp4Writer(out, episode.rate_hz) as video:
        for instant in replay(
            episode, tracker, controller, scale=scale, wanted=range(frame_count), frame_count=frame_count
        ):
            picture = draw_instant(instant)
            caption = caption or Caption(title, frame_count, picture.shape[1])
            video.write(np.concatenate([picture, caption.draw(instant)]))
