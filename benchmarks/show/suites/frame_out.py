"""How the suite ``frame-out`` is shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.contract.rows import Row
from benchmarks.judges.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.show.charts import FEWEST, Chart, curves_of, recovery, series_mean
from benchmarks.show.pictures import EventPicture, ShownEvent
from benchmarks.show.showing import Showing
from benchmarks.show.video.drawing import InLargerView

_CAR_LENGTH_M = 4.5
_LENGTHS = range(25, 91)
"""Lengths of a frame-out to show: long enough to lose a target, short enough to see where it went."""
_CELL_PX = 600
_CAPTION = (
    "the first frame-out of 25 to 90 frames, just before, in its middle, at its end, and five frames after the whole "
    "target is back. White: the camera's picture; its surroundings are not shown to trackers. Blue: the target. "
    "Orange: the estimate. Yellow: the particles."
)


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return the error while outside and the time to recover."""
    return [
        Chart(
            title="Where is the target while outside the picture?",
            words="Mean error over all frame-outs of at least this length; a lost or silent tracker counts with the "
            "capped worst error.",
            curves=curves_of(drawn, lambda rows: series_mean(rows, "offscreen_error_by_frame_m", fewest=FEWEST)),
            x_label="frames since the target left the picture",
            x_scale="frames",
            y_label="error on the ground, m",
            y_scale="log",
            rule=(_CAR_LENGTH_M, "one car length"),
        ),
        Chart(
            title="How soon is it found again?",
            words="Kaplan–Meier: a target that is never found counts as lost for as long as it was watched.",
            curves=curves_of(drawn, recovery),
            x_label="frames since the target was back in full",
            x_scale="frames",
            y_label="found again",
            steps=True,
            shaded=(RECOVERY_WINDOW_FRAMES, "← counts as recovered"),
        ),
    ]


def first_frame_out(rows: Sequence[Row]) -> ShownEvent | None:
    """Return the first frame-out by seed that lasts 25 to 90 frames and can be judged."""
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["back_frame"]]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        left, length, back = (row["frame_out"][key] for key in ("exit_frame", "length_frames", "back_frame"))
        if length in _LENGTHS and left > 0:
            frames = [left - 1, left + length // 2, left + length - 1, back + RECOVERY_WINDOW_FRAMES]
            return ShownEvent(row["seed"], frames, "One frame-out", _CAPTION)
    return None


SHOWING = Showing(
    heading="What happens outside the picture",
    charts=charts,
    event_picture=EventPicture(first_frame_out, lambda episode: InLargerView(_CELL_PX), _CELL_PX, scale=2.5),
    oracles="Oracles know the map and the target's state at the exit, and get no picture until it is back: "
    "what they miss is hardly predictable.",
)
