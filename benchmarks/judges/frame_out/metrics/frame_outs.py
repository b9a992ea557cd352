"""Frame-outs: the stretches of an episode in which the target is wholly outside the picture."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from benchmarks.judges.frame_out.metrics.series import TruthSeries
from benchmarks.judges.runs import runs

Kind = Literal["road", "excursion", "outside", "unseen"]


@dataclass(frozen=True, slots=True)
class FrameOut:
    """One frame-out.

    Attributes:
        index: its place in the episode, from 0.
        exit_frame: first frame with state ``out``.
        length_frames: number of frames in a row with state ``out``.
        back_frame: first frame after them with state ``in`` (whole and seen); None if the target left again or the
            episode ended before.
        watch_end_frame: first frame of the next frame-out, or the number of frames: end of the watch for recovery.
        kind: ``excursion`` if the target was off the road on any frame from the exit to ``back_frame`` (or the last
            frame outside), else ``road``; ``outside`` in a scene without roads, and in a real sequence whose files say
            so of one of its frames; else there ``unseen``: outside the picture or hidden.
        side: side of the picture by which it left; "" where it is not known.
        turned: whether it turned at a crossing while outside; None where it is not known.
        long: whether it lasts longer than any that the preset draws, e.g. because the pilot flew on without having seen
            where the car went; None where it draws none.
    """

    index: int
    exit_frame: int
    length_frames: int
    back_frame: int | None
    watch_end_frame: int
    kind: Kind
    side: str = ""
    turned: bool | None = None
    long: bool | None = None

    @property
    def first_frame(self) -> int:
        """``exit_frame``, under the name common to all absences."""
        return self.exit_frame

    def attributes(self) -> dict[str, Any]:
        """Return its attributes in rows."""
        return {name: value for name, value in asdict(self).items() if name != "watch_end_frame"}


def find_frame_outs(truth: TruthSeries) -> list[FrameOut]:
    """Return the episode's frame-outs in order: every maximal stretch of frames with state ``out``."""
    found: list[FrameOut] = []
    spans = runs(truth.state == "out")
    watch_ends = [*(exit_frame for exit_frame, _ in spans[1:]), len(truth.state)]
    for (exit_frame, end), watch_end in zip(spans, watch_ends, strict=False):
        whole_again = np.flatnonzero(truth.state[end:watch_end] == "in")
        back_frame = end + int(whole_again[0]) if len(whole_again) else None
        until = end if back_frame is None else back_frame
        side = str(truth.side[exit_frame])
        said = truth.outside is not None and bool(truth.outside[exit_frame:end].any())
        kind: Kind = "outside" if side or said else "unseen"
        if truth.on_road is not None:
            kind = "road" if truth.on_road[exit_frame:until].all() else "excursion"
        turned = None if truth.turning is None else bool(truth.turning[exit_frame:end].any())
        long = None if truth.longest_frames is None else end - exit_frame > truth.longest_frames
        length_frames = end - exit_frame
        found.append(FrameOut(len(found), exit_frame, length_frames, back_frame, watch_end, kind, side, turned, long))
    return found
