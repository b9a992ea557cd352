"""Real tracks as the suite ``fish`` judges them: gaps cut out of unbroken pieces, and links between pieces."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from benchmarks.contract.judging import USUAL_RATE_HZ, Ending, Score, TimeBlock
from benchmarks.contract.track_table import TrackTable
from benchmarks.judges.fish.gap_protocol import BLOCK_FRAMES, Tracks
from benchmarks.judges.fish.gap_scores import GapTask, gap_scores
from benchmarks.judges.fish.link_scores import LENGTHS, link_events, link_scores
from benchmarks.judges.fish.motion import motion_scores
from benchmarks.judges.fish.scale import TANK_PX, scaled_to_tank
from benchmarks.judges.fish.tracklets import link_tracklets
from scenarios.scenario import Frame
from sim.checks import check
from trackers.types import CameraCommand

STRIDE_FRAMES = 50
"""Frames from one cut gap of an animal to its next of the same length."""
_FAR_PX = 1000.0
"""No animal goes so far from one frame to the next."""


class FishRecording:
    """See ``benchmarks.contract.judging.Recording``. Blocks are those of the gap protocol.

    Places in another unit than pixels are scaled, see ``scaled_to_tank``, since methods are made for pixels.
    """

    def __init__(self, table: TrackTable) -> None:
        self.name = table.name
        interval_s = 1.0 / (table.rate_hz or USUAL_RATE_HZ)
        position_px = table.position if table.unit == "px" else scaled_to_tank(table.position)
        self._tracks = Tracks(position_px, interval_s)

    @cached_property
    def fingerprint(self) -> str:
        """See ``Recording``."""
        content = f"{self.name}\0{self._tracks.interval_s}\0{self._tracks.position_px.shape}".encode()
        return hashlib.sha256(content + np.ascontiguousarray(self._tracks.position_px).tobytes()).hexdigest()[:10]

    @cached_property
    def _task(self) -> GapTask:
        flat = self._tracks.position_px.reshape(-1, 2)
        cap_px = float(np.hypot(*(np.nanmax(flat, axis=0) - np.nanmin(flat, axis=0))))
        return GapTask(self._tracks, STRIDE_FRAMES, cap_px, sees_mates=False)

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``. There is no frame."""

    def sheet(self) -> RecordingSheet:
        """See ``Judge``."""
        return RecordingSheet(self)

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield the scores of gaps cut out, of which no method sees the other animals, and of links."""
        if ending.new_gap_method is None:
            return
        gaps = self._task.bridged(ending.new_gap_method).by_block()
        links = link_tracklets(ending.new_gap_method, self._tracks, self._task.jump_px)
        for block in sorted({*gaps, *(link.gap.first_frame // BLOCK_FRAMES for link in links)}):
            own = [link for link in links if link.gap.first_frame // BLOCK_FRAMES == block]
            bridged = list(gap_scores(self._tracks, gaps[block])) if block in gaps else []
            first = block * BLOCK_FRAMES
            motion = motion_scores(self._tracks.position_px[first : first + BLOCK_FRAMES], None)
            for score in (*bridged, *link_scores(own, groups=LENGTHS), *link_events(own), *motion):
                yield replace(score, block=TimeBlock(block, BLOCK_FRAMES))


class RecordingSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``: takes no answers."""

    def __init__(self, recording: FishRecording) -> None:
        self._recording = recording

    def keep(self, frame: Frame, answer: Any) -> None:
        """See ``ScoreSheet``. There is no frame."""

    def scores(self, ending: Ending) -> Iterator[Score]:
        """See ``ScoreSheet``."""
        return self._recording.scores(ending)


def recordings(tables: Sequence[TrackTable]) -> tuple[list[FishRecording], list[str], list[str]]:
    """Return the recordings in tracks, notes about them, and what is wrong with those that cannot be used.

    Raises:
        ValueError: for two recordings of one name.
    """
    names = [each.name for each in tables]
    twice = sorted({name for name in names if names.count(name) > 1})
    check("real", not twice, "recordings of different names", f"two called {', '.join(twice)}")
    found, notes, unusable = [], list[str](), list[str]()
    for table in tables:
        tracked = _without_zeros(table)
        notes += [*table.notes, *_notes(table, tracked)]
        try:
            found.append(FishRecording(tracked))
        except ValueError as error:
            unusable.append(f"{table.name}: {error}")
    return found, notes, unusable


def _without_zeros(table: TrackTable) -> TrackTable:
    """Return tracks without places of exactly 0, 0, which programs write for an animal that they do not find.

    An animal that is nowhere else is left there.
    """
    zero = (table.position == 0.0).all(axis=2)
    elsewhere = (np.isfinite(table.position[..., 0]) & ~zero).any(axis=0)
    return replace(table, position=np.where((zero & elsewhere)[..., None], np.nan, table.position))


def _notes(table: TrackTable, tracked: TrackTable) -> Iterator[str]:
    """Yield what a user should know of a file: units and rate that are taken, and places that cannot be right."""
    rate = "" if table.rate_hz else f"; it tells no frame rate, {USUAL_RATE_HZ:g} a second are taken"
    scaled = f"; places in {table.unit} are scaled to {TANK_PX:g} px from the leftmost to the rightmost"
    unit = "" if table.unit == "px" else scaled
    if rate or unit:
        yield f"{table.name}{unit}{rate}"
    zeros = int(np.isfinite(table.position[..., 0]).sum() - np.isfinite(tracked.position[..., 0]).sum())
    if zeros:
        yield f"{table.name}: {zeros} places of exactly 0, 0 are taken as not tracked"
    step = np.linalg.norm(np.diff(tracked.position, axis=0), axis=2)
    far = step > _FAR_PX
    if table.unit == "px" and far.any():
        frame, animal = np.unravel_index(np.nanargmax(step), step.shape)
        longest = f"the longest {step[frame, animal]:,.0f} px, of animal {table.names[animal]} to frame "
        where = f"{longest}{table.first_frame + frame + 1}"
        yield f"{table.name}: {int(far.sum())} jumps of more than {_FAR_PX:,.0f} px in one frame, {where}"
