"""Events of an episode with people: occlusions, changes of light, other people near the camera."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, get_args

import numpy as np

from benchmarks.judges.runs import runs
from benchmarks.judges.stereo.metrics.people import SEEN_AT_LEAST, PeopleSeries
from scenarios.stereo_follow.truth import LightEvent
from scenarios.visibility import MOSTLY_SEEN

OCCLUSION, NEAR, NOBODY_NEAR = "occlusion", "near person", "nobody near"
LIGHT_KINDS: tuple[str, ...] = get_args(LightEvent)
_SHORTEST_OCCLUSION_FRAMES = 2
_LIGHT_CHANGE_S = 2.0


@dataclass(frozen=True, slots=True)
class PeopleEvent:
    """A stretch of an episode.

    Attributes:
        index: its place in the episode's list of events, from 0.
        kind: ``occlusion``, a change of light (``lamp on`` …), ``near person`` or ``nobody near``.
        first_frame, length_frames: the stretch; for a change of light two seconds from its first frame.
        back_frame: first frame after an occlusion on which half of the target is visible; None if the target is hidden
            again, or the episode ends, before. None for other events.
        watch_end_frame: first frame of the next occlusion, or the number of frames.
        place: where the target is on its first frame.
    """

    index: int
    kind: str
    first_frame: int
    length_frames: int
    back_frame: int | None
    watch_end_frame: int
    place: str

    @property
    def end_frame(self) -> int:
        """The frame after the last one."""
        return self.first_frame + self.length_frames

    def attributes(self) -> dict[str, Any]:
        """Return its attributes in rows; ``light`` is true for every change of light."""
        values = {name: value for name, value in asdict(self).items() if name != "watch_end_frame"}
        return {**values, "light": self.kind in LIGHT_KINDS}


def find_events(truth: PeopleSeries) -> list[PeopleEvent]:
    """Return the episode's events: occlusions, changes of light, and stretches with and without a person near.

    An occlusion is a maximal run of at least 2 frames on which less than a tenth of the target is seen, which is in the
    picture, at least in part. A change of light begins directly after another one, too; a frame within two seconds of
    two of them is in both. Frame 0, which is given, is in no stretch.
    """
    found: list[PeopleEvent] = []
    frame_count = len(truth.place)
    counted = np.arange(frame_count) > 0

    def add(kind: str, first: int, end: int, back: int | None = None, watch_end: int = frame_count) -> None:
        found.append(PeopleEvent(len(found), kind, first, end - first, back, watch_end, str(truth.place[first])))

    hidden = (truth.visible_fraction < SEEN_AT_LEAST) & ~truth.out & counted
    occlusions = [(first, end) for first, end in runs(hidden) if end - first >= _SHORTEST_OCCLUSION_FRAMES]
    watch_ends = [*(first for first, _ in occlusions[1:]), frame_count]
    for (first, end), watch_end in zip(occlusions, watch_ends, strict=False):
        back = np.flatnonzero(truth.visible_fraction[end:watch_end] >= MOSTLY_SEEN)
        add(OCCLUSION, first, end, end + int(back[0]) if len(back) else None, watch_end)
    lights = truth.light_event
    for first in np.flatnonzero((lights[1:] != "") & (lights[1:] != lights[:-1])).tolist():
        add(str(lights[first + 1]), first + 1, min(first + 1 + round(_LIGHT_CHANGE_S * truth.rate_hz), frame_count))
    for kind, flags in ((NEAR, truth.near_person), (NOBODY_NEAR, ~truth.near_person)):
        for first, end in runs(flags & counted):
            add(kind, first, end)
    return found
