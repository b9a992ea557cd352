"""Real tracks as the suite ``fish`` judges them: gaps cut out of unbroken pieces, and links between pieces."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from benchmarks.suites.fish.gap_protocol import BLOCK_FRAMES, Tracks
from benchmarks.suites.fish.gap_scores import GapTask, gap_scores
from benchmarks.suites.fish.link_scores import LENGTHS, link_events, link_scores
from benchmarks.suites.fish.motion import motion_scores
from benchmarks.suites.fish.scale import TANK_PX, scaled_to_tank
from benchmarks.suites.fish.tracklets import link_tracklets
from benchmarks.suites.judging import Ending, Score
from benchmarks.track_files.reading import read_tracks
from benchmarks.track_files.table import TrackTable

STRIDE_FRAMES = 50
"""Frames from one cut gap of an animal to its next of the same length."""
USUAL_RATE_HZ = 30.0
"""Frame rate where a file does not tell one."""


class FishRecording:
    """See ``benchmarks.suites.judging.Recording``. Blocks are those of the gap protocol.

    Places in another unit than pixels are scaled, see ``scaled_to_tank``, since methods are made for pixels.
    """

    def __init__(self, table: TrackTable) -> None:
        self.name = table.name
        self.block_frames = BLOCK_FRAMES
        interval_s = 1.0 / (table.rate_hz or USUAL_RATE_HZ)
        position_px = table.position if table.unit == "px" else scaled_to_tank(table.position)
        self._tracks = Tracks(position_px, interval_s)

    @cached_property
    def _task(self) -> GapTask:
        flat = self._tracks.position_px.reshape(-1, 2)
        cap_px = float(np.hypot(*(np.nanmax(flat, axis=0) - np.nanmin(flat, axis=0))))
        return GapTask(self._tracks, STRIDE_FRAMES, cap_px, sees_mates=False)

    def scores(self, ending: Ending) -> Iterator[tuple[int, list[Score]]]:
        """See ``Recording``: of gaps cut out, of which no method sees the other animals, and of links."""
        if ending.new_gap_method is None:
            return
        gaps = self._task.bridged(ending.new_gap_method).by_block()
        links = link_tracklets(ending.new_gap_method, self._tracks, self._task.jump_px)
        for block in sorted({*gaps, *(link.gap.first_frame // BLOCK_FRAMES for link in links)}):
            mine = [link for link in links if link.gap.first_frame // BLOCK_FRAMES == block]
            bridged = list(gap_scores(self._tracks, gaps[block])) if block in gaps else []
            first = block * BLOCK_FRAMES
            motion = motion_scores(self._tracks.position_px[first : first + BLOCK_FRAMES], None)
            yield block, [*bridged, *link_scores(mine, groups=LENGTHS), *link_events(mine), *motion]


def recordings(files: Sequence[Path]) -> list[FishRecording]:
    """Return the recordings in files of tracking programs; ValueError for what cannot be read."""
    tables = read_tracks(files)
    for table in tables:
        rate = "" if table.rate_hz else f"; it tells no frame rate, {USUAL_RATE_HZ:g} a second are taken"
        unit = (
            ""
            if table.unit == "px"
            else f"; places in {table.unit} are scaled to {TANK_PX:g} px from the leftmost to the rightmost"
        )
        if rate or unit:
            print(f"note: {table.name}{unit}{rate}", file=sys.stderr)
    return [FishRecording(table) for table in tables]
