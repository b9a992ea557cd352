"""How the suite ``frame-out`` is shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.contract.rows import LAST_METRIC, Row
from benchmarks.judges.frame_out.metrics.localisation import PRECISION_PX, THRESHOLDS
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.judges.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.show.charts import FEWEST, Chart, Curve, curves_of, recovery, scored, series_mean
from benchmarks.show.pictures import EventPicture, ShownEvent
from benchmarks.show.showing import Showing
from benchmarks.show.video.drawing import InLargerView

_IOU_STEP = float(THRESHOLDS[1])
_LENGTHS = range(25, 91)
"""Lengths of a frame-out to show: long enough to lose a target, short enough to see where it went."""
_CELL_PX = 600
_NOTICED = 3
"""Least length of an absence to show, frames."""
_ON_FOOTAGE = (
    "White: the camera's picture, around it what earlier ones showed; trackers get the picture alone. Blue: the true "
    "box. Orange: the estimate and its path. Yellow: the particles."
)
_CAPTION = (
    "the first frame-out of 25 to 90 frames, just before, in its middle, at its end, and five frames after the whole "
    "target is back. White: the camera's picture; its surroundings are not shown to trackers. Blue: the target. "
    "Orange: the estimate. Yellow: the particles."
)


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return the error while outside, the time to recover, and OTB's plots of the frames in view."""
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
            rule=target_length(drawn),
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
        Chart(
            title="How well do the boxes fit?",
            words="Success plot of OTB: frames in view whose box overlaps the true one by more than the threshold. "
            "The area under the curve is the success AUC.",
            curves=curves_of(drawn, lambda rows: series_mean(rows, "success_curve", step_x=_IOU_STEP)),
            labels=scored(drawn, FRAME_OUT.metric("success_auc")),
            legend="area under the curve, % (95 % interval)",
            x_label="overlap threshold, IoU",
            x_scale="linear",
            y_label="frames with more overlap",
        ),
        Chart(
            title="How near are the centres?",
            words="Precision plot of OTB: frames in view whose centre is at most so far from the true one.",
            curves=curves_of(drawn, precision),
            labels=scored(drawn, FRAME_OUT.metric("precision_20_px")),
            legend=f"at {PRECISION_PX:g} px, % (95 % interval)",
            x_label="centre error, px",
            x_scale="linear",
            y_label="frames with no more error",
            mark=(PRECISION_PX, f"{PRECISION_PX:g} px"),
        ),
    ]


def target_length(drawn: Mapping[str, Sequence[Row]]) -> tuple[float, str] | None:
    """Return the length of the target in metres, in words: one tracker's error in metres over that in lengths."""
    for rows in drawn.values():
        in_m, in_lengths = (
            sum(row["value"] * row["weight"] for row in rows if row["metric"] == name)
            for name in ("offscreen_error_m", "offscreen_error_car_lengths")
        )
        if in_m and in_lengths:
            return in_m / in_lengths, "one length of the target"
    return None


def precision(rows: Sequence[Row]) -> Curve | None:
    """Return OTB's precision plot; None without it, or where rows of an earlier version lack it in some episodes."""
    alike = (sum(row["metric"] == name for row in rows) for name in ("precision_plot", "success_curve"))
    return series_mean(rows, "precision_plot") if len(set(alike)) == 1 else None


def first_frame_out(rows: Sequence[Row]) -> ShownEvent | None:
    """Return the first frame-out by seed that lasts 25 to 90 frames and can be judged."""
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["back_frame"]]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        left, length, back = (row["frame_out"][key] for key in ("exit_frame", "length_frames", "back_frame"))
        if length in _LENGTHS and left > 0:
            frames = [left - 1, left + length // 2, left + length - 1, back + RECOVERY_WINDOW_FRAMES]
            return ShownEvent(row["seed"], frames, "One frame-out", _CAPTION)
    return None


def first_absence(rows: Sequence[Row]) -> ShownEvent | None:
    """Return the first absence of a real sequence that can be judged and lasts three frames; without one four frames of
    the first sequence.
    """
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["length_frames"] >= _NOTICED]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        left, length, back = (row["frame_out"][key] for key in ("exit_frame", "length_frames", "back_frame"))
        frames = [max(left - 1, 0), left + length // 2, back, back + RECOVERY_WINDOW_FRAMES]
        when = "the first absence, just before, in its middle, at its end, and five frames later. "
        return ShownEvent(row["seed"], frames, "One absence", when + _ON_FOOTAGE)
    counts = {row["seed"]: int(row["value"]) for row in rows if row["metric"] == LAST_METRIC}
    if not counts:
        return None
    last = counts[first := min(counts)] - 1
    frames = np.linspace(0, last, 4).round().astype(int).tolist()
    return ShownEvent(first, frames, "One sequence", f"four of its frames. {_ON_FOOTAGE}")


SHOWING = Showing(
    heading="What happens outside the picture",
    charts=charts,
    sequence_picture=EventPicture(first_absence, lambda episode: InLargerView(_CELL_PX), _CELL_PX, scale=1.5),
    event_picture=EventPicture(first_frame_out, lambda episode: InLargerView(_CELL_PX), _CELL_PX, scale=2.5),
    oracles="Oracles know the map and the target's state at the exit, and get no picture until it is back: "
    "what they miss is hardly predictable.",
)
