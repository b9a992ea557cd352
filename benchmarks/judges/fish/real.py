"""Real tracks as the suite ``fish`` judges them: gaps cut out of unbroken pieces, and links between pieces."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import USUAL_RATE_HZ, Ending, Score, TimeBlock
from benchmarks.contract.track_table import TrackTable
from benchmarks.judges.fish.gap_protocol import BLOCK_FRAMES, GapTask, Tracks
from benchmarks.judges.fish.gap_scores import gap_scores
from benchmarks.judges.fish.links import LENGTHS, link_events, link_scores
from benchmarks.judges.fish.motion import motion_scores
from benchmarks.judges.fish.tracklets import link_tracklets
from scenarios.scenario import Frame
from sim.checks import check
from trackers.types import CameraCommand

STRIDE_FRAMES = 50
"""Frames from one cut gap of an animal to its next of the same length."""
TANK_PX = 600.0
"""Length of the simulated tank in the overview's picture, which methods have parameters for."""


class FishRecording:
    """See ``benchmarks.contract.judging.Recording``; its own sheet, as it takes no answers.

    Blocks are those of the gap protocol. Places in another unit than pixels are scaled, see ``scaled_to_tank``, since
    methods are made for pixels.
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
        x0, y0, x1, y1 = self._tracks.bounds_xyxy[-1]
        return GapTask(self._tracks, STRIDE_FRAMES, float(np.hypot(x1 - x0, y1 - y0)), sees_mates=False)

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``. There is no frame."""

    def sheet(self) -> FishRecording:
        """See ``Judge``."""
        return self

    def keep(self, frame: Frame, answer: Any) -> None:
        """See ``ScoreSheet``. There is no frame."""

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield the scores of gaps cut out, of which no method sees the other animals, and of links."""
        if ending.new_gap_method is None:
            return
        bridged = self._task.bridged(ending.new_gap_method)
        links = link_tracklets(ending.new_gap_method, self._tracks)
        starts = [each.gap.first for each in (*bridged.extrapolated, *bridged.interpolated)]
        starts += [link.gap.first_frame for link in links]
        for block in sorted({start // BLOCK_FRAMES for start in starts}):
            first = block * BLOCK_FRAMES
            own = [link for link in links if first <= link.gap.first_frame < first + BLOCK_FRAMES]
            gaps = gap_scores(self._tracks, bridged.of_block(block))
            motion = motion_scores(self._tracks.position_px[first : first + BLOCK_FRAMES], None)
            for score in (*gaps, *link_scores(own, groups=LENGTHS), *link_events(own), *motion):
                yield replace(score, block=TimeBlock(block, BLOCK_FRAMES))


def scaled_to_tank(position: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places (T, N, 2) of any unit in pixels, scaled so that the box of all is as wide as the tank is long.

    Raises:
        ValueError: for places that do not differ in x.
    """
    width = float(np.nanmax(position[..., 0]) - np.nanmin(position[..., 0]))
    check("position", width > 0.0, "places that differ in x", f"a width of {width:g}")
    return position * (TANK_PX / width)


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
