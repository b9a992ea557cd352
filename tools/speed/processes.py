"""Speed of a tracker in a process of its own: what it costs a frame beside the same tracker in this process."""

from __future__ import annotations

import sys
import time
from contextlib import closing
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.run.own_inputs import own
from scenarios import catalog
from scenarios.loop import first_box
from tools.speed import still
from tools.speed.figures import Figure, milliseconds
from trackers.clients.remote import Program, RemoteTracker, remote_tracker
from trackers.types import Observation

_UNTIMED_FRAMES = 5


def measure_process(scenario: str, preset: str, frames: int, seed: int) -> dict[str, Figure]:
    """Return the figures of a tracker that does nothing, on the first pictures of an episode: medians over frames.

    Args:
        frames: number of timed ones.
    """
    with closing(catalog.scenario(scenario).episode(preset, seed)) as episode:
        count = min(frames + _UNTIMED_FRAMES, episode.frame_count)
        observations = [own(episode.step().observation) for _ in range(count)]
        start = episode.start
    box_xyxy = np.zeros(4) if start.box_xyxy is None else first_box(start)
    program = Program((sys.executable, str(Path(still.__file__))))
    remote = remote_tracker(program, {}, np.random.default_rng(0))
    assert isinstance(remote, RemoteTracker)
    here_s, _ = _spent_s(still.Still(None, None), observations, box_xyxy)
    there_s, cpu_s = _spent_s(remote, observations, box_xyxy)
    remote.release(whole=False)
    return {"process_wall_ms": milliseconds(there_s - here_s), "process_cpu_ms": milliseconds(cpu_s)}


def _spent_s(
    tracker: still.Still | RemoteTracker, observations: list[Observation], box_xyxy: np.ndarray
) -> tuple[float, float]:
    """Return the wall time of an update, and the CPU time of this process and the tracker's."""
    wall_s, cpu_s = [], []
    tracker.initialise(observations[0], box_xyxy)
    for observation in observations[1:]:
        began_s, began_cpu_s = time.perf_counter(), time.process_time()
        tracker.update(observation)
        wall_s.append(time.perf_counter() - began_s)
        elsewhere_s = tracker.elsewhere_cpu_s if isinstance(tracker, RemoteTracker) else 0.0
        cpu_s.append(time.process_time() - began_cpu_s + elsewhere_s)
    return median(wall_s[_UNTIMED_FRAMES:]), median(cpu_s[_UNTIMED_FRAMES:])
