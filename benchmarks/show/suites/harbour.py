"""How the suite ``harbour`` is shown."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.contract.metric import Mean
from benchmarks.contract.rows import Row
from benchmarks.judges.harbour.suite import CURVE, FOUND
from benchmarks.judges.harbour.visits import SEEABLE
from benchmarks.show.charts import Chart, Curve, curve_of, curves_of, found_at_alarms
from benchmarks.show.pictures import EventPicture, ShownEvent
from benchmarks.show.showing import Showing
from benchmarks.show.video.harbour import HarbourDrawing
from benchmarks.statistics.bootstrap import Interval, interval_of
from benchmarks.statistics.pooling import Froc

_ALARMS = np.geomspace(0.1, 500.0, 75)
_CONTRASTS = SEEABLE * 2.0 ** np.arange(-2, 12)
"""Ends of the classes of contrast to noise, octaves."""
_LONG_FRAMES = 8
"""Least length of a visit to show."""
_AFTER_FRAMES = (3, 30)
"""Frames from its first one to those that are shown, or to its last one."""
_CAPTION = (
    "the earliest arrival that can be seen and stays for 8 frames, on its fourth frame and a minute after its first. "
    "Left the thermal picture with 3-D boxes, right all of it from above, the camera below. Blue: intruders. Orange: "
    "tracks on one. Red: tracks on nothing, false alarms from their fourth frame on, with their causes. Grey: tracks "
    "at an intruder that do not count, as they are misplaced, or it is mostly hidden or not watched."
)


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return the FROC curves, and detection by contrast to noise."""
    return [
        Chart(
            title="How many false alarms does a find cost?",
            words="Share of the intruders that can be seen, found four frames running, chance taken off, against false "
            "alarms an hour, as the least confidence that is answered falls.",
            curves=curves_of(drawn, lambda rows: found_at_alarms(rows, Froc(*CURVE, high=1.0), _ALARMS)),
            x_label="false alarms an hour",
            x_scale="log",
            y_label="found",
        ),
        Chart(
            title="What contrast does it take?",
            words="Share found, chance taken off, of intruders in classes of contrast to noise, an octave each; the "
            f"contrast is the most that an intruder has on four frames running. Below {SEEABLE:g} nobody could see "
            "them.",
            curves=curves_of(drawn, by_contrast),
            x_label="contrast to noise",
            x_scale="log",
            y_label="found",
        ),
    ]


def by_contrast(rows: Sequence[Row]) -> Curve | None:
    """Return the share found against contrast to noise; None without rows."""
    both = [row | {"metric": "found"} for row in rows if row["metric"] in ("found", "found_unseen")]

    def found(low: float, high: float) -> Interval | None:
        return interval_of(Mean(FOUND), [row for row in both if low <= row["event"]["contrast_to_noise"] < high])

    return curve_of((float(np.sqrt(low * high)), found(low, high)) for low, high in itertools.pairwise(_CONTRASTS))


def first_visit(rows: Sequence[Row]) -> ShownEvent | None:
    """Return the earliest visit of 8 frames that begins after the first frame and can be seen, of the first seed."""
    visits = [(row["seed"], row["event"]) for row in rows if row["metric"] == "found"]
    long = [each for each in visits if each[1]["first_frame"] > 0 and each[1]["length_frames"] >= _LONG_FRAMES]
    if not long:
        return None
    seed, visit = min(long, key=lambda each: (each[0], each[1]["first_frame"], each[1]["index"]))
    frames = [visit["first_frame"] + min(after, visit["length_frames"] - 1) for after in _AFTER_FRAMES]
    return ShownEvent(seed, frames, f"A {visit['kind']} comes", _CAPTION)


SHOWING = Showing(
    heading="Who comes into the harbour?",
    charts=charts,
    event_picture=EventPicture(first_visit, HarbourDrawing, cell_width_px=900),
    drawings={"harbour": HarbourDrawing},
)
