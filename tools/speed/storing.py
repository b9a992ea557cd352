"""Speed of a data set: an episode made and written with all channels, against bare calls of PyBullet's renderer.

Both are timed in one run, on the same scene, camera and size: the making in CPU time of the process, since codecs and
tables may use threads, a bare call of TinyRenderer with shadows after every eighth frame (see ``figures``). Then each
channel's values are coded once more, alone.
"""

from __future__ import annotations

import dataclasses
import tempfile
import time
from contextlib import closing
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
from tools.speed.figures import FRAMES_PER_BARE_CALL, Figure, bare_cpu_s, milliseconds

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


def measure_storing(scenario: str, preset: str, frames: int, seed: int) -> dict[str, Figure]:
    """Return the figures of making and writing an episode, and of the bytes of each channel.

    Args:
        frames: of the episode.
    """
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    bare = Request(scenario, preset, (seed, seed + 1), ())
    request = dataclasses.replace(bare, channels=existing_channels(bare))
    with tempfile.TemporaryDirectory() as rehearsal:
        # Kernels are compiled, or loaded.
        _made(*place_of(rehearsal), request, seed, frames)
    with tempfile.TemporaryDirectory() as folder:
        files, root = place_of(folder)
        made_s, bare_s = _made(files, root, request, seed, frames)
        files.pipe_file(f"{root}/{REQUEST}", request.as_json().encode())
        data = DataSet(folder)
        stored, count, coded_s = data.stored_bytes(), len(data), _coding_s(data, seed)
    return {
        "stored_frame_over_tinyrenderer": Figure(made_s, bare_s, better="lower"),
        "stored_frame_cpu_ms": milliseconds(made_s),
        "tinyrenderer_cpu_ms": milliseconds(bare_s),
        **{f"{channel}_coding_cpu_ms": milliseconds(coded_s[channel]) for channel in request.channels},
        **{
            f"{channel}_kib": Figure(stored[channel] / count / 1024, unit="KiB", better="lower")
            for channel in request.channels
        },
    }


def _made(files: Any, root: str, request: Request, seed: int, frames: int) -> tuple[float, float]:
    """Return the CPU seconds a frame of making and writing an episode, and those of a bare call."""
    with closing(request.episode(seed)) as live:
        interrupted = _Interrupted(live, frames)
        began = time.process_time()
        write_episode(files, root, request, seed, cast(Episode, interrupted))
        taken = time.process_time() - began - interrupted.interrupted_s
    return taken / interrupted.frame_count, float(np.mean(interrupted.bare_s))


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
