"""Speed of a data set: an episode made and written with all channels, against bare calls of PyBullet's renderer.

Both are timed in one run, on the same scene, camera and size: the making in CPU time of the process, since codecs and
tables may use threads, a bare call of TinyRenderer with shadows after every eighth frame (see ``rendering``). Then each
channel's values are coded once more, alone.
"""

from __future__ import annotations

import dataclasses
import tempfile
import time
from typing import Any, cast

import cv2
import numba
import numpy as np

from benchmarks.data.sets.channels import CODINGS, NORMALS, coding_of, value_of
from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import write_episode
from benchmarks.data.sets.generating import FramesAlone
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import Request, existing_channels
from scenarios.scenario import Episode, Frame
from sim.bullet import TinyRenderer
from tools.speed.rendering import FRAMES_PER_BARE_CALL, Figure, bare_cpu_s, entries_of

_CODED_FRAMES = 20


class _Interrupted(FramesAlone):
    """An episode that is interrupted by bare calls, whose time it keeps."""

    def __init__(self, episode: Episode, frames: int) -> None:
        super().__init__(episode, frames)
        self._reference = TinyRenderer(self.world)
        self.bare_s: list[float] = []
        self.interrupted_s = 0.0

    def step(self) -> Frame:
        """Return the next frame."""
        frame: Frame = self._episode.step()
        if frame.truth.frame % FRAMES_PER_BARE_CALL == FRAMES_PER_BARE_CALL - 1:
            began = time.process_time()
            self.bare_s.append(bare_cpu_s(self._reference, frame))
            self.interrupted_s += time.process_time() - began
        return frame


def measure_storing(scenario: str, preset: str, seeds: range, frames: int) -> list[dict[str, Any]]:
    """Return the entries of ``summary.json`` on making and writing frames, and on the bytes of each channel.

    Args:
        frames: of each episode.
    """
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    asked = Request(scenario, preset, (seeds.start, seeds.stop), ())
    request = dataclasses.replace(asked, channels=existing_channels(asked))
    made_s, bare_s, coded_s = [], [], []
    coding_ms: dict[str, list[float]] = {channel: [] for channel in request.channels}
    kibibytes: dict[str, list[float]] = {channel: [] for channel in request.channels}
    for seed in seeds:
        with tempfile.TemporaryDirectory() as rehearsal:
            # Kernels are compiled, or loaded.
            _made(*place_of(rehearsal), request, seed, frames)
        with tempfile.TemporaryDirectory() as folder:
            files, root = place_of(folder)
            seconds, bare = _made(files, root, request, seed, frames)
            files.pipe_file(f"{root}/{REQUEST}", request.as_json().encode())
            data = DataSet(folder)
            stored = data.stored_bytes()
            for channel in request.channels:
                kibibytes[channel].append(stored[channel] / len(data) / 1024)
            each = _coding_s(data, seed)
            data.close()
        made_s.append(seconds)
        bare_s.append(float(np.mean(bare)))
        coded_s.append(sum(each.values()))
        for channel, second in each.items():
            coding_ms[channel].append(1e3 * second)
    ones = [1.0] * len(seeds)
    figures: list[Figure] = [
        ("stored_frame_over_tinyrenderer", "ratio", "lower", made_s, bare_s),
        ("stored_frame_cpu_ms", "ms", "lower", [1e3 * each for each in made_s], ones),
        ("tinyrenderer_cpu_ms", "ms", "lower", [1e3 * each for each in bare_s], ones),
        ("coding_share", "fraction", "higher", coded_s, made_s),
        *((f"{channel}_coding_cpu_ms", "ms", "lower", coding_ms[channel], ones) for channel in request.channels),
        *((f"{channel}_kib", "KiB", "lower", kibibytes[channel], ones) for channel in request.channels),
    ]
    return entries_of(scenario, preset, "data set", seeds, figures)


def _made(files: Any, root: str, request: Request, seed: int, frames: int) -> tuple[float, list[float]]:
    """Return the CPU seconds a frame of making and writing an episode, and those of bare calls."""
    live = request.episode(seed)
    try:
        interrupted = _Interrupted(live, frames)
        began = time.process_time()
        write_episode(files, root, request, seed, cast(Episode, interrupted))
        taken = time.process_time() - began - interrupted.interrupted_s
    finally:
        live.close()
    return taken / interrupted.frame_count, interrupted.bare_s


def _coding_s(data: DataSet, seed: int) -> dict[str, float]:
    """Return the CPU seconds of coding each channel of a frame."""
    episode, seconds = data.episode(seed), dict.fromkeys(data.request.channels, 0.0)
    count = min(_CODED_FRAMES, len(episode))
    for k in range(count):
        frame = episode.frame(k)
        for channel in seconds:
            value = episode.normals_of(k) if channel == NORMALS else value_of(frame, channel, episode.normals)
            if value is not None:
                encode = CODINGS[coding_of(channel, data.request.pictures)].encode
                began = time.process_time()
                encode(value)
                seconds[channel] += (time.process_time() - began) / count
    return seconds
