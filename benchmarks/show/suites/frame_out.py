"""How the suite ``frame-out`` is shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from benchmarks.contract.rows import Row
from benchmarks.judges.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.show.charts import FEWEST, Chart, CurveChart, curves_of, recovery, series_mean
from benchmarks.show.pictures import Event, EventPicture
from benchmarks.show.showing import Showing
from benchmarks.show.video.drawing import InLargerView

_CAR_LENGTH_M = 4.5
_LENGTHS = range(25, 91)
"""Lengths of a frame-out to show: long enough to lose a car, short enough to see where it went."""
_CELL_PX = 600
_CAPTION = (
    "the first frame-out of 25 to 90 frames, just before, in its middle, at its end, and five frames after the whole "
    "car is back. White: the camera's picture; its surroundings are not shown to trackers. Blue: the car. Orange: the "
    "estimate. Yellow: the particles."
)


def charts(drawn: Mapping[str, Sequence[Row]]) -> Iterator[Chart]:
    """Yield the error while outside and the time to recover."""
    errors = curves_of(drawn, lambda rows: series_mean(rows, "offscreen_error_by_frame_m", fewest=FEWEST))
    if errors:
        yield CurveChart(
            title="Where is the car while outside the picture?",
            words="Mean error over all frame-outs of at least this length; a lost or silent tracker counts with the "
            "capped worst error. Bands: 95 % bootstrap over seeds.",
            curves=errors,
            x_label="frames since the car left the picture",
            y_label="error on the ground, m",
            y_scale="log",
            rule=(_CAR_LENGTH_M, "one car length"),
        )
    found = curves_of(drawn, recovery)
    if found:
        yield CurveChart(
            title="How soon is it found again?",
            words="Kaplan–Meier: a car that is never found counts as lost for as long as it was watched. "
            "Bands: 95 % bootstrap over seeds.",
            curves=found,
            x_label="frames since the car was back in full",
            y_label="found again",
            steps=True,
            shaded=(RECOVERY_WINDOW_FRAMES, "← counts as recovered"),
        )


def first_frame_out(rows: Sequence[Row]) -> tuple[int, Event] | None:
    """Return seed and attributes of the first frame-out by seed that lasts 25 to 90 frames and can be judged."""
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["back_frame"]]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        if row["frame_out"]["length_frames"] in _LENGTHS and row["frame_out"]["exit_frame"] > 0:
            return row["seed"], row["frame_out"]
    return None


def _frames(frame_out: Event) -> list[int]:
    exit_frame, length, back = frame_out["exit_frame"], frame_out["length_frames"], frame_out["back_frame"]
    return [exit_frame - 1, exit_frame + length // 2, exit_frame + length - 1, back + RECOVERY_WINDOW_FRAMES]


SHOWING = Showing(
    heading="What happens outside the picture",
    charts=charts,
    event_picture=EventPicture(
        find=first_frame_out,
        frames=_frames,
        words=lambda frame_out: ("One frame-out", _CAPTION),
        drawing=lambda episode: InLargerView(_CELL_PX),
        cell_width_px=_CELL_PX,
        scale=2.5,
    ),
    oracles="Oracles know the map and the car's state at the exit, and get no picture until the car is back: "
    "what they miss is hardly predictable.",
    remarks={
        "hold": "Why can hold be ahead of particle filters? It looks at every picture anew, around the place in the "
        "picture where it matched last, and takes what is most like the car there. The filters as written look where "
        "their particles are, and nothing in them searches the whole picture: one that is off the car when it leaves "
        "is hardly ever on it when it is back. Nor does hold know where the car is meanwhile: see the error outside.",
    },
)
